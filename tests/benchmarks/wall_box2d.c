/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * A wall of boxes in Box2D 3: wall_box2d STEPS TIME_STEP SUBSTEPS ACCELERATION FREQUENCY <BRICKS
 *
 * Each line of BRICKS is the left, bottom, right and top of a brick (m); the first is the fixed
 * base.  A sine of the base acceleration (m/s2, Hz) acts on all bricks as a body force.  Printed
 * are "time" with the processor time of the steps (s), "reaction" with the vertical force on the
 * base in the last substep (N), and the four vertices of each brick, one brick a line.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "box2d/box2d.h"

enum { MOST = 100000, MOST_CONTACTS = 4096 };

static const float gravity = 9.81f, density = 2500.0f;
static b2BodyId body[MOST];
static float width[MOST], height[MOST];

/* Read the bricks into the world; return their number. */
static int build(b2WorldId world) {
    const float friction = tanf(35.0f * B2_PI / 180.0f);
    float left, bottom, right, top;
    int count = 0;
    while (count < MOST && scanf("%f %f %f %f", &left, &bottom, &right, &top) == 4) {
        b2BodyDef definition = b2DefaultBodyDef();
        definition.type = count ? b2_dynamicBody : b2_staticBody;
        definition.position.x = 0.5f * (left + right);
        definition.position.y = 0.5f * (bottom + top);
        b2ShapeDef shape = b2DefaultShapeDef();
        shape.density = density;
        shape.material.friction = friction;
        width[count] = 0.5f * (right - left);
        height[count] = 0.5f * (top - bottom);
        b2Polygon box = b2MakeBox(width[count], height[count]);
        body[count] = b2CreateBody(world, &definition);
        b2CreatePolygonShape(body[count++], &shape, &box);
    }
    return count;
}

/* Return the vertical force on the base: normal and friction impulses of the last substep. */
static double reaction(double substep) {
    static b2ContactData contact[MOST_CONTACTS];
    const int count = b2Body_GetContactData(body[0], contact, MOST_CONTACTS);
    double sum = 0.0;
    for (int i = 0; i < count; i++) {
        const b2Manifold *manifold = &contact[i].manifold;
        for (int k = 0; k < manifold->pointCount; k++) {
            sum += fabs(manifold->points[k].normalImpulse * manifold->normal.y);
        }
    }
    return sum / substep;
}

/* Print the vertices, counter-clockwise from the lower left. */
static void print_vertices(int count) {
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 4; k++) {
            const b2Vec2 corner = {(k == 1 || k == 2) ? width[i] : -width[i],
                                   k >= 2 ? height[i] : -height[i]};
            const b2Vec2 arm = b2RotateVector(b2Body_GetRotation(body[i]), corner);
            printf("%.9g %.9g ", (double)b2Body_GetPosition(body[i]).x + arm.x,
                   (double)b2Body_GetPosition(body[i]).y + arm.y);
        }
        printf("\n");
    }
}

int main(int argc, char **argv) {
    if (argc != 6) {
        fprintf(stderr, "usage: wall_box2d STEPS TIME_STEP SUBSTEPS ACCELERATION FREQUENCY\n");
        return 1;
    }
    const int steps = atoi(argv[1]), substeps = atoi(argv[3]);
    const double time_step = atof(argv[2]), amplitude = atof(argv[4]), frequency = atof(argv[5]);
    b2WorldDef definition = b2DefaultWorldDef();
    definition.enableSleep = false;
    b2WorldId world = b2CreateWorld(&definition);
    const int count = build(world);
    const clock_t start = clock();
    for (int i = 0; i < steps; i++) {
        const double phase = 2.0 * B2_PI * frequency * (i + 1) * time_step;
        b2World_SetGravity(world, (b2Vec2){(float)(-amplitude * sin(phase)), -gravity});
        b2World_Step(world, (float)time_step, substeps);
    }
    printf("time %.6f\n", (double)(clock() - start) / CLOCKS_PER_SEC);
    printf("reaction %.9g\n", reaction(time_step / substeps));
    print_vertices(count);
    b2DestroyWorld(world);
    return 0;
}
