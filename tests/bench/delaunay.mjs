// Delaunay triangulation of the sites in a file and its Voronoi diagram, by d3-delaunay: prints the least seconds of
// some runs.
import { readFileSync } from "node:fs";
import { Delaunay } from "d3-delaunay";

const [file, side] = process.argv.slice(2);
const sites = Float64Array.from(readFileSync(file, "utf8").trim().split(/\s+/), Number);
let least = Infinity;
for (let i = 0; i < 15; i++) {
  const since = performance.now();
  new Delaunay(sites).voronoi([0, 0, Number(side), Number(side)]);
  least = Math.min(least, performance.now() - since);
}
console.log((least / 1000).toFixed(9));
