/*
 * A line with and without input shaping, a mass that vibrates on the axis, and an output half way: what is left of the
 * vibration, how far the axis is behind what it would be without a shape, and that the output comes where it is.
 */
#include "splineway.h"
#include <math.h>
#include <stdio.h>

#define FREQUENCY 45.0
#define DAMPING 0.05
#define CYCLE 0.001
#define LENGTH 50000000

static splineway_core core;

/* A mass on a spring under an axis that accelerates, and how far it is off it, mm. */
struct mass {
    double off, speed, pull;
};

static void swing(struct mass *mass, double acceleration)
{
    const double natural = 2.0 * 3.14159265358979 * FREQUENCY / sqrt(1.0 - DAMPING * DAMPING);
    for (int step = 0; step < 50; ++step) {
        const double given = mass->pull + (acceleration - mass->pull) * (step + 0.5) / 50.0;
        mass->speed += CYCLE / 50.0
                       * (-natural * natural * mass->off - 2.0 * DAMPING * natural * mass->speed - given);
        mass->off += CYCLE / 50.0 * mass->speed;
    }
    mass->pull = acceleration;
}

static splineway_result begin(uint32_t kind, float frequency, float damping, bool unlike)
{
    static const int64_t start[SPLINEWAY_AXES] = {0};
    splineway_config config;
    splineway_config_init(&config, 300.0f, 2000.0f, 400000.0f);
    config.tolerance = 0.05f;
    for (int axis = 0; axis < SPLINEWAY_AXES; ++axis) {
        config.shape[axis].kind = axis > 0 && unlike ? SPLINEWAY_SHAPER_NONE : kind;
        config.shape[axis].frequency = frequency;
        config.shape[axis].damping = damping;
    }
    return splineway_init(&core, sizeof core, &config, start);
}

/* What is left of the vibration when the machine rests, mm; the axis passes the middle `late` s behind the output, at `middle` s. */
static double run(uint32_t kind, double *late, double *middle, int *cycles)
{
    static const int64_t to[SPLINEWAY_AXES] = {LENGTH};
    const splineway_block options = {.feed = 100.0f, .tolerance = -1.0f, .tag = 1};
    const splineway_switch half = {.output = SPLINEWAY_OUTPUT_DIGITAL, .value = 1.0f,
        .trigger = SPLINEWAY_TRIGGER_END, .distance = -25.0f};
    struct mass mass = {0.0, 0.0, 0.0};
    splineway_setpoint setpoint;
    splineway_switched switched[4];
    double left = 0.0, at = -1.0;
    int64_t before = 0;
    uint32_t count;
    float level;
    int rested = 0;

    if (begin(kind, (float)FREQUENCY, (float)DAMPING, false) != SPLINEWAY_RESULT_OK
        || splineway_push_line(&core, to, &options) != SPLINEWAY_RESULT_OK
        || splineway_push_switch(&core, &half) != SPLINEWAY_RESULT_OK || splineway_finish(&core) != SPLINEWAY_RESULT_OK) {
        return -1.0;
    }
    *middle = -1.0;
    *cycles = 0;
    for (int cycle = 0; cycle < 3000 && rested < 300; ++cycle) {
        splineway_progress progress = splineway_settle(&core);
        if (splineway_tick_outputs(&core, &setpoint, switched, 4, &count, &level) != SPLINEWAY_RESULT_OK) {
            return -1.0;
        }
        if (count > 0) {
            at = cycle + switched[0].fraction;
        }
        if (before < LENGTH / 2 && setpoint.position[0] >= LENGTH / 2) {
            const double part = (double)(LENGTH / 2 - before) / (double)(setpoint.position[0] - before);
            *middle = (cycle + part) * CYCLE;
        }
        before = setpoint.position[0];
        swing(&mass, setpoint.acceleration[0]);
        if (progress == SPLINEWAY_PROGRESS_DONE && setpoint.activity == SPLINEWAY_ACTIVITY_IDLE) {
            left = fabs(mass.off) > left ? fabs(mass.off) : left;
            *cycles += rested == 0 ? cycle : 0;
            ++rested;
        }
    }
    *late = *middle - at * CYCLE;
    return rested == 300 && before == LENGTH ? left : -1.0;
}

/* Everything that must be refused. */
static int wrong(void)
{
    splineway_motor belts[2] = {{.factors = {1.0f, 1.0f}}, {.factors = {1.0f, -1.0f}}};
    float seconds;
    int failures = 0;

    failures += splineway_shaper_delay(NULL, &seconds) != SPLINEWAY_RESULT_NOT_READY;
    failures += begin(5, 45.0f, 0.05f, false) != SPLINEWAY_RESULT_CONFIG;
    failures += begin(SPLINEWAY_SHAPER_ZV, 0.0f, 0.05f, false) != SPLINEWAY_RESULT_CONFIG;
    failures += begin(SPLINEWAY_SHAPER_ZV, NAN, 0.05f, false) != SPLINEWAY_RESULT_CONFIG;
    failures += begin(SPLINEWAY_SHAPER_ZV, 45.0f, 0.6f, false) != SPLINEWAY_RESULT_CONFIG;
    /* A half wave of 1 s is more than there are servo cycles to remember. */
    failures += begin(SPLINEWAY_SHAPER_SMOOTH, 1.5f, 0.05f, false) != SPLINEWAY_RESULT_CONFIG;
    failures += splineway_shaper_delay(&core, &seconds) != SPLINEWAY_RESULT_NOT_READY;
    for (int motor = 0; motor < 2; ++motor) {
        belts[motor].velocity = 200.0f;
        belts[motor].acceleration = 2000.0f;
        belts[motor].jerk = 400000.0f;
    }
    /* What a belt is given must be what the axes it moves are given. */
    failures += begin(SPLINEWAY_SHAPER_ZV, 45.0f, 0.05f, true) != SPLINEWAY_RESULT_OK;
    failures += splineway_set_motors(&core, belts, 2) != SPLINEWAY_RESULT_CONFIG;
    failures += begin(SPLINEWAY_SHAPER_ZV, 45.0f, 0.05f, false) != SPLINEWAY_RESULT_OK;
    failures += splineway_set_motors(&core, belts, 2) != SPLINEWAY_RESULT_OK;
    failures += splineway_shaper_delay(&core, NULL) != SPLINEWAY_RESULT_NULL;
    return failures;
}

int main(void)
{
    static const char *const names[] = {"none", "ZV", "MZV", "EI", "smooth"};
    int cycles = 0, failures = wrong();

    for (uint32_t kind = SPLINEWAY_SHAPER_NONE; kind <= SPLINEWAY_SHAPER_SMOOTH; ++kind) {
        double late = 1.0, middle = 0.0;
        float delay = -1.0f;
        const double left = run(kind, &late, &middle, &cycles);
        failures += splineway_shaper_delay(&core, &delay) != SPLINEWAY_RESULT_OK;
        printf("%s: %.1f um left, %.2f ms behind, half way at %.2f ms, the output %.4f ms before, %d cycles\n", names[kind],
               left * 1000.0, (double)delay * 1000.0, middle * 1000.0, late * 1000.0, cycles);
        failures += fabs(late) > 0.000005;
        failures += kind == SPLINEWAY_SHAPER_NONE ? left < 0.015 : left < 0.0 || left > 0.0015;
    }
    printf("%d wrong\n", failures);
    return failures;
}
