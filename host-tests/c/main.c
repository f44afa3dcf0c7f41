/*
 * The example on a host: prints the last setpoint, and checks every one, and what the library answers to
 * wrong calls.
 */
#include "example.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int cycles, broken;
static splineway_setpoint last;

static void drive(const splineway_setpoint *setpoint)
{
    int axis;
    for (axis = 0; axis < SPLINEWAY_AXES; ++axis) {
        const double moved = (double)(setpoint->position[axis] - last.position[axis]) * 1e-6;
        broken += moved > 0.2001 || moved < -0.2001;
        broken += setpoint->velocity[axis] > 200.0f || setpoint->velocity[axis] < -200.0f;
        broken += setpoint->acceleration[axis] > 2000.0f || setpoint->acceleration[axis] < -2000.0f;
    }
    last = *setpoint;
    ++cycles;
}

/* Limits of travel: from -1 to 1 mm in X, up to 2 mm in Y. */
static int beyond(splineway_core *core, const splineway_block *options)
{
    static const int64_t out[SPLINEWAY_AXES] = {1000001};
    static const int64_t in[SPLINEWAY_AXES] = {1000000, -5000000};
    static const int64_t high[SPLINEWAY_AXES] = {0, 2000001};
    splineway_travel travel[SPLINEWAY_AXES];
    int axis, failures = 0;

    for (axis = 0; axis < SPLINEWAY_AXES; ++axis) {
        travel[axis].least = INT64_MIN;
        travel[axis].greatest = INT64_MAX;
    }
    travel[0].least = 1;
    travel[0].greatest = 0;
    failures += splineway_set_travel(core, travel) != SPLINEWAY_RESULT_CONFIG;
    travel[0].least = -1000000;
    travel[0].greatest = INT64_MAX - 1;
    failures += splineway_set_travel(core, travel) != SPLINEWAY_RESULT_CONFIG;
    failures += splineway_set_travel(core, NULL) != SPLINEWAY_RESULT_NULL;
    travel[0].greatest = 1000000;
    travel[1].greatest = 2000000;
    failures += splineway_set_travel(core, travel) != SPLINEWAY_RESULT_OK;
    failures += splineway_push_line(core, out, options) != SPLINEWAY_RESULT_TRAVEL;
    failures += splineway_push_line(core, high, options) != SPLINEWAY_RESULT_TRAVEL;
    failures += splineway_push_line(core, in, options) != SPLINEWAY_RESULT_OK;
    return failures;
}

/* Other limits for the blocks to come; and how many servo cycles two kinds of hold take. */
static int calmer(splineway_core *core)
{
    splineway_axis axes[SPLINEWAY_AXES];
    int axis, failures = 0;

    for (axis = 0; axis < SPLINEWAY_AXES; ++axis) {
        axes[axis].velocity = 100.0f;
        axes[axis].acceleration = 500.0f;
        axes[axis].jerk = 20000.0f;
        axes[axis].rotary = false;
    }
    failures += splineway_set_limits(core, NULL) != SPLINEWAY_RESULT_NULL;
    failures += splineway_set_limits(core, axes) != SPLINEWAY_RESULT_OK;
    axes[0].jerk = NAN;
    failures += splineway_set_limits(core, axes) != SPLINEWAY_RESULT_CONFIG;
    return failures;
}

static int cycles_to_rest(bool quick)
{
    static splineway_core core;
    static const int64_t start[SPLINEWAY_AXES] = {0};
    static const int64_t far[SPLINEWAY_AXES] = {300000000};
    const splineway_block options = {100.0f, 0.0f, -1.0f, false, 1};
    splineway_config config;
    splineway_setpoint setpoint;
    int cycle;

    splineway_config_init(&config, 200.0f, 1000.0f, 20000.0f);
    config.stop[0].acceleration = 4000.0f;
    config.stop[0].jerk = 400000.0f;
    if (splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_OK
        || splineway_push_line(&core, far, &options) != SPLINEWAY_RESULT_OK) {
        return -1;
    }
    splineway_finish(&core);
    for (cycle = 0; cycle < 1000; ++cycle) {
        splineway_settle(&core);
        splineway_tick(&core, &setpoint);
    }
    if (quick) {
        splineway_quick_hold(&core);
    } else {
        splineway_hold(&core);
    }
    for (cycle = 0; cycle < 1000; ++cycle) {
        splineway_settle(&core);
        splineway_tick(&core, &setpoint);
        if (setpoint.activity == SPLINEWAY_ACTIVITY_IDLE) {
            break;
        }
    }
    return cycle;
}

/* A tool that bears less: quick stops keep what it bears, or the limits of stops, not what the machine had at first. */
static int stops_calmly(void)
{
    static splineway_core core;
    static const int64_t start[SPLINEWAY_AXES] = {0};
    static const int64_t far[SPLINEWAY_AXES] = {300000000};
    const splineway_block options = {50.0f, 0.0f, -1.0f, false, 1};
    splineway_axis axes[SPLINEWAY_AXES];
    splineway_config config;
    splineway_setpoint setpoint;
    float before = 0.0f, most[2] = {0.0f, 0.0f};
    int axis, cycle;

    splineway_config_init(&config, 200.0f, 2000.0f, 50000.0f);
    config.stop[0].acceleration = 400.0f;
    for (axis = 0; axis < SPLINEWAY_AXES; ++axis) {
        axes[axis].velocity = 100.0f;
        axes[axis].acceleration = 200.0f;
        axes[axis].jerk = 2000.0f;
        axes[axis].rotary = false;
    }
    if (splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_OK
        || splineway_set_limits(&core, axes) != SPLINEWAY_RESULT_OK
        || splineway_push_line(&core, far, &options) != SPLINEWAY_RESULT_OK) {
        return 1;
    }
    splineway_finish(&core);
    for (cycle = 0; cycle < 3000; ++cycle) {
        if (cycle == 1500) {
            splineway_quick_hold(&core);
        }
        splineway_settle(&core);
        splineway_tick(&core, &setpoint);
        most[0] = fmaxf(most[0], fabsf(setpoint.acceleration[0]));
        most[1] = fmaxf(most[1], fabsf(setpoint.acceleration[0] - before) / config.cycle);
        before = setpoint.acceleration[0];
    }
    /* Of jerk nothing was said. */
    return setpoint.activity != SPLINEWAY_ACTIVITY_IDLE || most[0] > 401.0f || most[1] > 2010.0f;
}

/* A surface 2 mm below is probed, and the axis then homed on it. */
static int seeks(void)
{
    static splineway_core core;
    static const int64_t start[SPLINEWAY_AXES] = {0};
    static const int64_t down[SPLINEWAY_AXES] = {-5000000};
    static const float direction[SPLINEWAY_AXES] = {-1.0f};
    splineway_axis_home axes[SPLINEWAY_AXES] = {{0}};
    splineway_probe_result probed = {SPLINEWAY_PROBE_OUTCOME_NONE, {0}};
    splineway_home_result homed = {SPLINEWAY_HOMING_NONE, 0, 0};
    splineway_config config;
    splineway_setpoint setpoint;
    float at_feed, most;
    int64_t before = 0, shift = 0;
    int cycle, sets = 0, failures = 0;

    failures += splineway_input(&core, -1, false, 0.0f) != SPLINEWAY_RESULT_NOT_READY;
    splineway_config_init(&config, 100.0f, 1000.0f, 20000.0f);
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_OK;
    failures += splineway_probe(&core, NULL, 10.0f, -1, true) != SPLINEWAY_RESULT_NULL;
    failures += splineway_probe(&core, down, 10.0f, -1, false) != SPLINEWAY_RESULT_INPUT;
    failures += splineway_probe(&core, down, 10.0f, SPLINEWAY_AXES, true) != SPLINEWAY_RESULT_INPUT;
    failures += splineway_input(&core, SPLINEWAY_AXES, true, 0.0f) != SPLINEWAY_RESULT_INPUT;
    failures += splineway_input(&core, -2, true, 0.0f) != SPLINEWAY_RESULT_INPUT;
    failures += splineway_probe(&core, down, 0.0f, -1, true) != SPLINEWAY_RESULT_OUT_OF_RANGE;
    splineway_hold(&core);
    failures += splineway_probe(&core, down, 10.0f, -1, true) != SPLINEWAY_RESULT_HELD;
    splineway_resume(&core);
    failures += splineway_probe_overshoot(&core, 10.0f, direction, &at_feed, &most) != SPLINEWAY_RESULT_OK;
    failures += splineway_probe(&core, down, 10.0f, -1, true) != SPLINEWAY_RESULT_OK;
    failures += splineway_home(&core, axes) != SPLINEWAY_RESULT_RUNNING;
    for (cycle = 0; cycle < 5000 && probed.outcome == SPLINEWAY_PROBE_OUTCOME_NONE; ++cycle) {
        splineway_settle(&core);
        splineway_tick(&core, &setpoint);
        if (before > -2000000 && setpoint.position[0] <= -2000000) {
            splineway_input(&core, -1, true,
                (float)(before + 2000000) / (float)(before - setpoint.position[0]));
        }
        before = setpoint.position[0];
        splineway_probed(&core, &probed);
    }
    failures += probed.outcome != SPLINEWAY_PROBE_OUTCOME_TRIPPED;
    failures += probed.position[0] < -2000100 || probed.position[0] > -1999900;
    failures += (float)(probed.position[0] - before) * 1e-6f > at_feed || at_feed > most;
    /* It stands on the switch: off, to it, off, to it slowly. */
    axes[0].wanted = true;
    axes[0].fast = -20.0f;
    axes[0].slow = 2.0f;
    axes[0].reach = 10000000;
    axes[0].back = 1000000;
    axes[0].at = 7000000;
    axes[0].parks = true;
    axes[0].park = 8000000;
    splineway_input(&core, 0, true, 0.0f);
    failures += splineway_home(&core, axes) != SPLINEWAY_RESULT_OK;
    for (cycle = 0; cycle < 20000 && homed.homing == SPLINEWAY_HOMING_NONE; ++cycle) {
        splineway_settle(&core);
        splineway_tick(&core, &setpoint);
        if (setpoint.activity == SPLINEWAY_ACTIVITY_SET) {
            shift = before - setpoint.position[0];
            ++sets;
        } else {
            splineway_input(&core, 0, setpoint.position[0] + shift <= -2000000, 1.0f);
        }
        before = setpoint.position[0];
        splineway_homed(&core, &homed);
    }
    failures += homed.homing != SPLINEWAY_HOMING_DONE || sets != 1;
    /* Told at the ends of cycles: to a cycle's way at 2 mm/s. */
    failures += before != 8000000 || shift < -9002000 || shift > -8998000;
    failures += splineway_set_position(&core, start) != SPLINEWAY_RESULT_OK;
    return failures;
}

static int wrong_calls(void)
{
    static splineway_core core, moved;
    static const int64_t start[SPLINEWAY_AXES] = {0};
    static const int64_t far[SPLINEWAY_AXES] = {INT64_MAX};
    static const splineway_arc nowhere = {{0, 99}, {0, 0}, true, 0};
    const splineway_block options = {50.0f, 0.0f, -1.0f, false, 1};
    const splineway_block backwards = {-50.0f, 0.0f, -1.0f, false, 1};
    /* None of these numbers is one; -0 is no rapid. */
    const splineway_block wrong[] = {
        {NAN, 0.0f, -1.0f, false, 1},        {1e-30f, 0.0f, -1.0f, false, 1},      {-0.0f, 0.0f, -1.0f, false, 1},
        {INFINITY, 0.0f, -1.0f, false, 1},   {50.0f, NAN, -1.0f, false, 1},        {50.0f, -1.0f, -1.0f, false, 1},
        {50.0f, 0.0f, NAN, false, 1},        {50.0f, 0.0f, -INFINITY, false, 1},   {50.0f, 0.0f, INFINITY, false, 1},
    };
    splineway_setpoint setpoint;
    size_t k;
    splineway_config config;
    splineway_report report;
    int failures = 0;

    failures += splineway_poll(&core) != SPLINEWAY_PROGRESS_NOT_READY;
    failures += splineway_push_line(&core, start, &options) != SPLINEWAY_RESULT_NOT_READY;
    failures += splineway_hold(NULL) != SPLINEWAY_RESULT_NOT_READY;
    failures += splineway_config_init(&config, 200.0f, 2000.0f, 50000.0f) != SPLINEWAY_RESULT_OK;
    failures += splineway_init(&core, 100, &config, start) != SPLINEWAY_RESULT_STORAGE;
    failures += splineway_init(&core, sizeof core, &config, NULL) != SPLINEWAY_RESULT_NULL;
    config.size = 0;
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_HEADER;
    config.size = sizeof config;
    config.axis_count = SPLINEWAY_AXES + 1;
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_AXES;
    config.axis_count = SPLINEWAY_AXES;
    config.cycle = -1.0f;
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_CONFIG;
    config.cycle = NAN;
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_CONFIG;
    config.cycle = 0.001f;
    config.tolerance = NAN;
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_CONFIG;
    config.tolerance = 0.01f;
    config.iterations = 0;
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_CONFIG;
    config.iterations = 40;
    config.sweeps = 65535;
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_CONFIG;
    config.sweeps = 8;
    config.axes[0].jerk = INFINITY;
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_CONFIG;
    config.axes[0].jerk = 50000.0f;
    config.stop[0].jerk = NAN;
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_CONFIG;
    config.stop[0].jerk = 0.0f;
    config.travel[0].least = 5;
    config.travel[0].greatest = 4;
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_CONFIG;
    config.travel[0].least = INT64_MIN;
    config.travel[0].greatest = INT64_MAX;
    failures += splineway_init(&core, sizeof core, &config, far) != SPLINEWAY_RESULT_COORDINATE;
    failures += splineway_tick(&core, &setpoint) != SPLINEWAY_RESULT_NOT_READY;
    failures += splineway_init((splineway_core *)((char *)&core + 1), sizeof core, &config, start)
                != SPLINEWAY_RESULT_STORAGE;
    failures += splineway_init(&core, sizeof core, &config, start) != SPLINEWAY_RESULT_OK;
    memcpy(&moved, &core, sizeof core);
    failures += splineway_tick(&moved, &setpoint) != SPLINEWAY_RESULT_NOT_READY;
    failures += splineway_tick(&core, NULL) != SPLINEWAY_RESULT_NULL;
    failures += splineway_push_line(&core, NULL, &options) != SPLINEWAY_RESULT_NULL;
    failures += splineway_push_line(&core, start, NULL) != SPLINEWAY_RESULT_NULL;
    failures += splineway_push_arc(&core, start, NULL, &options) != SPLINEWAY_RESULT_NULL;
    failures += splineway_push_cubic(&core, start, start, NULL, &options) != SPLINEWAY_RESULT_NULL;
    for (k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
        failures += splineway_push_line(&core, start, &wrong[k]) != SPLINEWAY_RESULT_OUT_OF_RANGE;
    }
    failures += splineway_push_dwell(&core, NAN, 1) != SPLINEWAY_RESULT_OUT_OF_RANGE;
    failures += splineway_push_dwell(&core, INFINITY, 1) != SPLINEWAY_RESULT_OUT_OF_RANGE;
    failures += splineway_push_line(&core, far, &options) != SPLINEWAY_RESULT_COORDINATE;
    failures += splineway_push_line(&core, start, &backwards) != SPLINEWAY_RESULT_OUT_OF_RANGE;
    failures += splineway_push_arc(&core, start, &nowhere, &options) != SPLINEWAY_RESULT_PLANE;
    failures += splineway_push_dwell(&core, -1.0f, 1) != SPLINEWAY_RESULT_OUT_OF_RANGE;
    failures += beyond(&core, &options);
    failures += calmer(&core);
    failures += seeks();
    failures += cycles_to_rest(false) < 150 || cycles_to_rest(true) > 40;
    failures += stops_calmly();
    failures += splineway_push_event(&core, true, 2) != SPLINEWAY_RESULT_OK;
    /* After an abort nothing is taken until the caller says that it knows. */
    failures += splineway_acknowledge_abort(&core);
    failures += splineway_quick_abort(&core) != SPLINEWAY_RESULT_OK;
    failures += splineway_push_line(&core, start, &options) != SPLINEWAY_RESULT_ABORTED;
    failures += splineway_acknowledge_abort(&core);
    failures += splineway_settle(&core) != SPLINEWAY_PROGRESS_ABORTED;
    failures += splineway_settle(&core) != SPLINEWAY_PROGRESS_ABORTED;
    failures += !splineway_acknowledge_abort(&core);
    failures += splineway_push_line(&core, start, &options) != SPLINEWAY_RESULT_OK;
    failures += splineway_feed_override(&core, 50) != SPLINEWAY_RESULT_OK;
    failures += splineway_status(&core, &report) != SPLINEWAY_RESULT_OK || report.blocks_waiting != 0;
    failures += strcmp(splineway_result_text(SPLINEWAY_RESULT_OK), "done") != 0;
    failures += strcmp(splineway_result_text(-7), "no result of splineway") != 0;
    return failures;
}

int main(void)
{
    const int result = example_run(drive);
    const int failures = wrong_calls();
    printf("result %d (%s), %d cycles, %d setpoints beyond a limit, %d wrong answers\n", result,
           splineway_result_text(result), cycles, broken, failures);
    printf("at X%" PRId64 " Y%" PRId64 " nm, block %" PRIu32 "\n", last.position[0], last.position[1], last.tag);
    return result != 0 || broken != 0 || failures != 0;
}
