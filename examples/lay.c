/* Introduces the whole job: a drawing in, stones out, each stone's polygon in hand.
 *   cc lay.c $(pkg-config --cflags --libs pave) -o lay && ./lay drawing.png stones.svg */
#include <pave/pave.h>

#include <stdio.h>

int main(int argc, char **argv)
{
    pave_context *context = NULL;
    pave_image *drawing = NULL;
    pave_stones *stones = NULL;
    pave_cvd_params cvd = PAVE_CVD_PARAMS_INIT;
    pave_lay_params params = PAVE_LAY_PARAMS_INIT;
    cvd.half_side = 5;
    params.cvd = &cvd;

    if (argc < 3 || pave_context_create(NULL, &context))
        return 2;
    pave_result result = pave_image_read(context, argv[1], &drawing);
    if (!result)
        result = pave_lay(context, drawing, &params, &stones);
    if (!result)
        result = pave_stones_write(context, stones, argv[2], NULL);
    if (result)
        fprintf(stderr, "%s\n", pave_context_message(context));
    for (int32_t i = 0; !result && i < pave_stones_count(stones) && i < 3; i++) {
        const double *at = pave_stones_vertices(stones) + 2 * pave_stones_starts(stones)[i];
        printf("stone %d begins at %.3f, %.3f\n", (int)pave_stones_sites(stones)[i], at[0], at[1]);
    }
    pave_stones_free(&stones);
    pave_image_free(&drawing);
    pave_context_free(&context);
    return result ? 1 : 0;
}
