/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * A run of ntdda without its window: wall_ntdda GEOMETRY ANALYSIS, in an empty folder.
 *
 * Printed after the line "time" with the processor time of the analysis (s) are the vertices of
 * each block, one block a line.
 */
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "dda.h"
#include "ddafile.h"
#include "geometrydata.h"
#include "analysisdata.h"

Filepaths filepath;

/* Numbers below 2^21: the search for holes in blocks expects this range, and never ends with that
 * of the C library. */
int rand(void) {
    static unsigned state = 2;
    state = 1103515245u * state + 12345u;
    return (int)((state >> 8) % (1u << 21));
}

void srand(unsigned seed) { (void)seed; }

/* Return the number of the convex block at a point; 0 if there is none. */
static int block_at(Geometrydata *geometry, double x, double y) {
    for (int block = 1; block <= geometry->nBlocks; block++) {
        const int first = geometry->vindex[block][1], last = geometry->vindex[block][2];
        int inside = 1;
        for (int i = first; i <= last; i++) {
            const double *p = geometry->vertices[i];
            const double *q = geometry->vertices[i < last ? i + 1 : first];
            inside &= (q[1] - p[1]) * (y - p[2]) >= (q[2] - p[2]) * (x - p[1]);
        }
        if (inside) return block;
    }
    return 0;
}

int main(int argc, char **argv) {
    if (argc != 3) return 1;
    DDA *dda = dda_new();
    Geometrydata *geometry = gdata_new();
    geometry->display_error = dda_display_error;
    geometry->display_warning = dda_display_warning;
    gdata_read_input_file(geometry, argv[1]);
    dda_set_geometrydata(dda, geometry);
    ddacut(geometry);
    for (int i = 1; i <= geometry->pointCount; i++) {
        double *point = geometry->points[i];
        point[3] = block_at(geometry, point[1], point[2]);
    }
    Analysisdata *analysis = adata_new();
    analysis->display_error = dda_display_error;
    analysis->display_warning = dda_display_warning;
    adata_read_input_file(analysis, argv[2], geometry->nFPoints, geometry->pointCount,
                          geometry->nLPoints);
    dda_set_analysisdata(dda, analysis);
    strcpy(filepath.rootname, "wall");
    const clock_t start = clock();
    ddanalysis(dda, &filepath);
    printf("\ntime %.6f\n", (double)(clock() - start) / CLOCKS_PER_SEC);
    for (int block = 1; block <= geometry->nBlocks; block++) {
        for (int i = geometry->vindex[block][1]; i <= geometry->vindex[block][2]; i++) {
            printf("%.17g %.17g ", geometry->vertices[i][1], geometry->vertices[i][2]);
        }
        printf("\n");
    }
    return 0;
}
