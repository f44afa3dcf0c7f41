/*
 * A square with a rounded corner, run by the core as a controller would run it: blocks in, one setpoint per
 * servo cycle out. It uses nothing but the header, so it compiles for a host and for a controller alike;
 * what drives the axes is up to `drive`.
 */
#include "example.h"

#define MM(x) ((int64_t)((x) * 1000000.0))

/* Storage for one core; it is not on the stack, and nothing is allocated. */
static splineway_core core;

static splineway_result push(int block, const splineway_block *options)
{
    static const int64_t corners[][SPLINEWAY_AXES] = {
        {MM(20.0), MM(0.0)}, {MM(20.0), MM(15.0)}, {MM(15.0), MM(20.0)}, {MM(0.0), MM(20.0)}, {MM(0.0), MM(0.0)},
    };
    static const splineway_arc arc = {{0, 1}, {MM(15.0), MM(15.0)}, false, 0};
    if (block == 2) {
        return splineway_push_arc(&core, corners[block], &arc, options);
    }
    if (block == 3) {
        /* A cubic curve with its Bezier points on the line. */
        static const int64_t first[SPLINEWAY_AXES] = {MM(10.0), MM(20.0)};
        static const int64_t second[SPLINEWAY_AXES] = {MM(5.0), MM(20.0)};
        return splineway_push_cubic(&core, first, second, corners[block], options);
    }
    return splineway_push_line(&core, corners[block], options);
}

int example_run(example_drive drive)
{
    static const int64_t start[SPLINEWAY_AXES] = {0};
    splineway_config config;
    splineway_block options = {.feed = 50.0f, .duration = 0.0f, .tolerance = -1.0f, .exact_stop = false, .tag = 0};
    splineway_setpoint setpoint = {.activity = SPLINEWAY_ACTIVITY_IDLE};
    splineway_progress progress;
    splineway_result result;
    int block = 0;

    splineway_config_init(&config, 200.0f, 2000.0f, 50000.0f);
    result = splineway_init(&core, sizeof core, &config, start);
    while (result == SPLINEWAY_RESULT_OK) {
        /* The background: blocks as long as there is room, then one planning step. */
        while (block < 5) {
            options.tag = (uint32_t)block + 1;
            result = push(block, &options);
            if (result == SPLINEWAY_RESULT_FULL) {
                break;
            }
            if (result != SPLINEWAY_RESULT_OK) {
                /* Refused, or ABORTED: the rest of the program must not be run from where the machine stands. */
                return (int)result;
            }
            ++block;
        }
        if (block == 5) {
            splineway_finish(&core);
        }
        progress = splineway_settle(&core);
        /* The servo interrupt. */
        result = splineway_tick(&core, &setpoint);
        if (drive != 0) {
            drive(&setpoint);
        }
        if (progress == SPLINEWAY_PROGRESS_DONE && setpoint.activity == SPLINEWAY_ACTIVITY_IDLE) {
            return 0;
        }
    }
    return (int)result;
}
