/* The main loop, as in the project of a user; for a target, where the example is compiled and linked. */
#include "motion.h"

int main(void)
{
    if (motion_start() != SPLINEWAY_RESULT_OK) {
        for (;;) {
        }
    }
    for (;;) {
        motion_poll();
    }
}
