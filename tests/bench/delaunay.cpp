// Delaunay triangulation of the sites in a file and its dual, by CGAL: prints the least seconds of some runs.
// Only this program links CGAL; it is built by tests/bench/run.sh and never installed.
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;

static double seconds()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// The Voronoi vertices, so that the work cannot be left out.
static double run(const std::vector<Point> &sites)
{
    CGAL::Delaunay_triangulation_2<Kernel> triangulation(sites.begin(), sites.end());
    double sum = 0;
    for (auto face = triangulation.finite_faces_begin(); face != triangulation.finite_faces_end(); ++face)
        sum += triangulation.dual(face).x();
    return sum;
}

int main(int argc, char **argv)
{
    std::ifstream file(argc > 1 ? argv[1] : "");
    std::vector<Point> sites;
    for (double x, y; file >> x >> y;)
        sites.emplace_back(x, y);
    if (sites.empty())
        return 1;
    double least = 1e9;
    volatile double sum = 0;
    for (int i = 0; i < 7; i++) {
        double since = seconds();
        sum = sum + run(sites);
        least = std::min(least, seconds() - since);
    }
    std::printf("%.9f\n", least);
}
