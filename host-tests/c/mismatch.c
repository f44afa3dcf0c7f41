/*
 * A header for another number of axes than the library: every call must be refused, and not a byte be written
 * to what the caller owns.
 */
#include "splineway.h"
#include <stdio.h>
#include <string.h>

static splineway_core core;

static int touched(const unsigned char *bytes, size_t count)
{
    int sum = 0;
    for (size_t k = 0; k < count; ++k) {
        sum += bytes[k] != 0xAA;
    }
    return sum;
}

int main(void)
{
    struct { splineway_config config; unsigned char guard[256]; } own;
    struct { splineway_setpoint setpoint; splineway_report report; unsigned char guard[256]; } out;
    static const int64_t start[SPLINEWAY_AXES] = {0};
    const splineway_block options = {50.0f, 0.0f, -1.0f, false, 1};
    const uint32_t interface = SPLINEWAY_INTERFACE + ((uint32_t)sizeof(splineway_activity) << 8);
    int failures = 0;

    memset(&own, 0xAA, sizeof own);
    memset(&out, 0xAA, sizeof out);
    failures += splineway_config_init(&own.config, 200.0f, 2000.0f, 50000.0f) != SPLINEWAY_RESULT_AXES;
    failures += touched((const unsigned char *)&own, sizeof own);
    /* Of its own size but another version, or other enumerations. */
    failures += splineway_config_init_sized(&own.config, sizeof own.config, interface + 1, 1.0f, 1.0f, 1.0f)
                != SPLINEWAY_RESULT_HEADER;
    failures += splineway_config_init_sized(&own.config, sizeof own.config, SPLINEWAY_INTERFACE, 1.0f, 1.0f, 1.0f)
                != SPLINEWAY_RESULT_HEADER;
    failures += touched((const unsigned char *)&own, sizeof own);
    /* A caller that does not look at results. */
    failures += splineway_init(&core, sizeof core, &own.config, start) == SPLINEWAY_RESULT_OK;
    failures += splineway_push_line(&core, start, &options) != SPLINEWAY_RESULT_NOT_READY;
    failures += splineway_poll(&core) != SPLINEWAY_PROGRESS_NOT_READY;
    failures += splineway_tick(&core, &out.setpoint) != SPLINEWAY_RESULT_NOT_READY;
    failures += splineway_status(&core, &out.report) != SPLINEWAY_RESULT_NOT_READY;
    failures += touched((const unsigned char *)&out, sizeof out);
    printf(failures == 0 ? "refused\n" : "%d failures\n", failures);
    return failures != 0;
}
