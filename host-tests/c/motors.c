/* A line along X on a machine with two belts: the motors keep their limits, and both go all the way. */
#include "splineway.h"
#include <stdio.h>

static splineway_core storage;

int main(void)
{
    splineway_motor belts[2] = {0};
    belts[0].factors[0] = belts[0].factors[1] = 1.0f;
    belts[1].factors[0] = 1.0f;
    belts[1].factors[1] = -1.0f;
    for (int i = 0; i < 2; i++) {
        belts[i].velocity = 200.0f;
        belts[i].acceleration = 2000.0f;
        belts[i].jerk = 50000.0f;
    }
    splineway_config config;
    int64_t start[SPLINEWAY_AXES] = {0}, to[SPLINEWAY_AXES] = {100000000, -100000000};
    if (splineway_config_init(&config, 1000.0f, 10000.0f, 250000.0f) != SPLINEWAY_RESULT_OK ||
        splineway_init(&storage, sizeof storage, &config, start) != SPLINEWAY_RESULT_OK)
        return 1;
    /* Both motors the same way: nothing would hold an axis. */
    splineway_motor twice[2] = {belts[0], belts[0]};
    splineway_result refused = splineway_set_motors(&storage, twice, 2);
    splineway_result taken = splineway_set_motors(&storage, belts, 2);
    splineway_block options = {.feed = 0.0f, .tolerance = -1.0f, .tag = 1};
    if (splineway_push_line(&storage, to, &options) != SPLINEWAY_RESULT_OK ||
        splineway_finish(&storage) != SPLINEWAY_RESULT_OK)
        return 2;
    splineway_setpoint setpoint;
    int64_t at[2], before[2] = {0, 0};
    float most = 0.0f;
    int cycles = 0;
    for (; cycles < 10000; cycles++) {
        splineway_progress progress = splineway_settle(&storage);
        splineway_tick(&storage, &setpoint);
        splineway_motor_positions(belts, 2, setpoint.position, at);
        for (int i = 0; i < 2; i++) {
            float speed = (float)(at[i] - before[i]) * 1e-3f;
            most = speed > most ? speed : -speed > most ? -speed : most;
            before[i] = at[i];
        }
        if (progress == SPLINEWAY_PROGRESS_DONE && setpoint.activity == SPLINEWAY_ACTIVITY_IDLE)
            break;
    }
    printf("refused %d, taken %d, %d cycles, at most %.1f mm/s, motors at %lld and %lld nm, running %d\n", refused,
           taken, cycles, (double)most, (long long)at[0], (long long)at[1],
           splineway_set_motors(&storage, belts, 9));
    return 0;
}
