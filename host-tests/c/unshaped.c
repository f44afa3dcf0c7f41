/* A library without input shaping must not take a machine that asks for it. */
#include "splineway.h"
#include <stdio.h>

int main(void)
{
    static splineway_core core;
    static const int64_t start[SPLINEWAY_AXES] = {0};
    splineway_config config;

    splineway_config_init(&config, 100.0f, 1000.0f, 20000.0f);
    config.shape[0].kind = SPLINEWAY_SHAPER_ZV;
    config.shape[0].frequency = 45.0f;
    puts(splineway_init(&core, sizeof core, &config, start) == SPLINEWAY_RESULT_CONFIG ? "refused" : "taken");
    return 0;
}
