#ifndef SPLINEWAY_H
#define SPLINEWAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
/*
 * splineway: motion interpolator core. Made from src/c by `UPDATE_HEADER=1 cargo test --test c_api`; not to
 * be edited.
 *
 * The library is built for one size of machine. Sizes and features are chosen in one place, a header
 * `splineway_config.h` in the include path, or the one that SPLINEWAY_CONFIG_FILE names; the builds with CMake and Make
 * (docs/c.md) read it too. What it does not define is as here. A library of another size refuses to work.
 *
 * Every call says which context it may come from:
 *
 *   background       The main loop, or the task of the lowest priority: one call at a time.
 *   servo interrupt  What comes once in every servo cycle, at a priority above the background's: a timer. It may interrupt
 *                    every other call, but not itself.
 *   any              These two and every other interrupt, above the servo interrupt or below it, also while any call is
 *                    under way.
 */
#if defined(SPLINEWAY_CONFIG_FILE)
#include SPLINEWAY_CONFIG_FILE
#elif defined(__has_include)
#if __has_include("splineway_config.h")
#include "splineway_config.h"
#endif
#endif
#ifndef SPLINEWAY_AXES
#define SPLINEWAY_AXES 3
#endif
#ifndef SPLINEWAY_BLOCKS
#define SPLINEWAY_BLOCKS 16
#endif
#ifndef SPLINEWAY_NODES
#define SPLINEWAY_NODES 64
#endif
#ifndef SPLINEWAY_OUTPUTS
#define SPLINEWAY_OUTPUTS 0
#endif
#ifndef SPLINEWAY_KINEMATICS
#define SPLINEWAY_KINEMATICS 0
#endif
#ifndef SPLINEWAY_SHAPING
#define SPLINEWAY_SHAPING 0
#endif
#ifndef SPLINEWAY_HISTORY
#define SPLINEWAY_HISTORY 64
#endif
/* With this header's size and version, and the compiler's size of an enumeration, so that a library of another touches nothing. */
#define splineway_config_init(config, velocity, acceleration, jerk) \
    splineway_config_init_sized((config), sizeof(splineway_config), \
                                SPLINEWAY_INTERFACE + ((uint32_t)sizeof(splineway_activity) << 8), (velocity), \
                                (acceleration), (jerk))


/*
 Bytes that a core takes at most; the build fails if it were more.
 */
#define SPLINEWAY_STORAGE_BYTES ((((((13600 + (4900 * SPLINEWAY_AXES)) + (SPLINEWAY_NODES * (200 + (80 * SPLINEWAY_AXES)))) + (SPLINEWAY_BLOCKS * (136 + (20 * SPLINEWAY_AXES)))) + (SPLINEWAY_OUTPUTS * 13000)) + (SPLINEWAY_KINEMATICS * (1200 + (256 * SPLINEWAY_AXES)))) + (SPLINEWAY_SHAPING * ((512 + (256 * SPLINEWAY_AXES)) + (SPLINEWAY_HISTORY * (8 + (36 * SPLINEWAY_AXES))))))

/*
 The same in words of 64 bits.
 */
#define SPLINEWAY_STORAGE_WORDS ((SPLINEWAY_STORAGE_BYTES / 8) + 1)

/*
 Version of the interface, which header and library must agree on.
 */
#define SPLINEWAY_INTERFACE 6

/*
 What came of a call.
 */
typedef enum {
  /*
   Done.
   */
  SPLINEWAY_RESULT_OK = 0,
  /*
   There is no room now: poll, and push the same block again.
   */
  SPLINEWAY_RESULT_FULL = 1,
  /*
   A pointer is null. (Without a core, `NOT_READY`.)
   */
  SPLINEWAY_RESULT_NULL = 2,
  /*
   The core is not set up.
   */
  SPLINEWAY_RESULT_NOT_READY = 3,
  /*
   The storage is smaller than this library needs, which was built for another size, or not aligned.
   */
  SPLINEWAY_RESULT_STORAGE = 4,
  /*
   The library was built for another number of axes.
   */
  SPLINEWAY_RESULT_AXES = 5,
  /*
   A limit or a setting is not finite or out of its range.
   */
  SPLINEWAY_RESULT_CONFIG = 6,
  /*
   A coordinate is beyond +-1e6 mm.
   */
  SPLINEWAY_RESULT_COORDINATE = 7,
  /*
   Feed, duration, tolerance, dwell, or the velocity or time of a jog is not finite or out of its range.
   */
  SPLINEWAY_RESULT_OUT_OF_RANGE = 8,
  /*
   The arc's plane names an axis that does not exist, or one twice.
   */
  SPLINEWAY_RESULT_PLANE = 9,
  /*
   Start and end of the arc are at different distances from its centre, or it has no radius.
   */
  SPLINEWAY_RESULT_ARC = 10,
  /*
   The block is too long.
   */
  SPLINEWAY_RESULT_TOO_LONG = 11,
  /*
   An abort was asked for and has not been acknowledged: nothing is taken.
   */
  SPLINEWAY_RESULT_ABORTED = 12,
  /*
   Header and library are not of the same version, or the configuration was not made by
   `splineway_config_init`.
   */
  SPLINEWAY_RESULT_HEADER = 13,
  /*
   The block or the point of a jog leads out of the limits of travel.
   */
  SPLINEWAY_RESULT_TRAVEL = 14,
  /*
   A jog while a program runs: hold it first.
   */
  SPLINEWAY_RESULT_RUNNING = 15,
  /*
   A jog back, but no program is held.
   */
  SPLINEWAY_RESULT_NO_PROGRAM = 16,
  /*
   A probe or homing: a hold, a stop or an override of 0 is in force, or a pause waits for its resume.
   */
  SPLINEWAY_RESULT_HELD = 17,
  /*
   A probe: the input is already as it would be at the end; or there is no such input.
   */
  SPLINEWAY_RESULT_INPUT = 18,
} splineway_result;

/*
 What a call of `splineway_poll` came to.
 */
typedef enum {
  /*
   A new plan was handed over.
   */
  SPLINEWAY_PROGRESS_PLANNED = 0,
  /*
   Nothing to do until the interpolator has moved on.
   */
  SPLINEWAY_PROGRESS_WAITING = 1,
  /*
   Nothing to do until more blocks come.
   */
  SPLINEWAY_PROGRESS_NEEDS_BLOCKS = 2,
  /*
   Everything that was pushed has been handed over.
   */
  SPLINEWAY_PROGRESS_DONE = 3,
  /*
   At rest because an operator asked for it.
   */
  SPLINEWAY_PROGRESS_HELD = 4,
  /*
   At rest after an abort, and everything that had been pushed is dropped. Said until
   `splineway_acknowledge_abort`.
   */
  SPLINEWAY_PROGRESS_ABORTED = 5,
  /*
   The core is not set up.
   */
  SPLINEWAY_PROGRESS_NOT_READY = 6,
  /*
   A part of the work has been done, and more can be done now: poll again.
   */
  SPLINEWAY_PROGRESS_PLANNING = 7,
} splineway_progress;

/*
 What the interpolator is doing.
 */
typedef enum {
  /*
   At rest: nothing to run.
   */
  SPLINEWAY_ACTIVITY_IDLE = 0,
  /*
   In motion.
   */
  SPLINEWAY_ACTIVITY_RUNNING = 1,
  /*
   In a dwell.
   */
  SPLINEWAY_ACTIVITY_DWELLING = 2,
  /*
   At an event of the program, whose tag the setpoint has: for one servo cycle.
   */
  SPLINEWAY_ACTIVITY_EVENT = 3,
  /*
   In a jog.
   */
  SPLINEWAY_ACTIVITY_JOGGING = 4,
  /*
   At rest, in other coordinates than before: what counts steps counts on from this position. For one servo cycle.
   */
  SPLINEWAY_ACTIVITY_SET = 5,
} splineway_activity;

/*
 An output.
 */
typedef enum {
  /*
   On or off, number 0 to 7.
   */
  SPLINEWAY_OUTPUT_DIGITAL = 0,
  /*
   Any value, number 0 to 3.
   */
  SPLINEWAY_OUTPUT_ANALOGUE = 1,
  /*
   The power of a tool.
   */
  SPLINEWAY_OUTPUT_POWER = 2,
} splineway_output;

/*
 How a probe ended.
 */
typedef enum {
  /*
   There is none, it is not over, or it has been said.
   */
  SPLINEWAY_PROBE_OUTCOME_NONE = 0,
  /*
   By its input.
   */
  SPLINEWAY_PROBE_OUTCOME_TRIPPED = 1,
  /*
   At its target, without it.
   */
  SPLINEWAY_PROBE_OUTCOME_MISSED = 2,
  /*
   By `splineway_jog_cancel` or an abort.
   */
  SPLINEWAY_PROBE_OUTCOME_CANCELLED = 3,
} splineway_probe_outcome;

/*
 What came of homing.
 */
typedef enum {
  /*
   There is none, it is not over, or it has been said.
   */
  SPLINEWAY_HOMING_NONE = 0,
  /*
   All axes are homed, and the coordinates set.
   */
  SPLINEWAY_HOMING_DONE = 1,
  /*
   A switch has not closed within the way it was given.
   */
  SPLINEWAY_HOMING_MISSING = 2,
  /*
   A switch is still closed after the way back.
   */
  SPLINEWAY_HOMING_STUCK = 3,
  /*
   By `splineway_jog_cancel` or an abort.
   */
  SPLINEWAY_HOMING_CANCELLED = 4,
} splineway_homing;

/*
 What of the program an output switches with.
 */
typedef enum {
  /*
   With the end of the block that was pushed last; of a dwell or an event as the motion leaves it, or at rest if nothing follows.
   */
  SPLINEWAY_TRIGGER_END = 0,
  /*
   With the start of the next motion.
   */
  SPLINEWAY_TRIGGER_START = 1,
  /*
   At rest, behind all that was pushed, before all that will be.
   */
  SPLINEWAY_TRIGGER_REST = 2,
} splineway_trigger;

/*
 How an axis is shaped.
 */
typedef enum {
  /*
   Not at all; it waits for the axes that are.
   */
  SPLINEWAY_SHAPER_NONE = 0,
  /*
   Two impulses, half a period apart: nothing is left of a vibration at exactly the frequency given. The shortest.
   */
  SPLINEWAY_SHAPER_ZV = 1,
  /*
   Three impulses over three quarters of a period: as exact, and wider.
   */
  SPLINEWAY_SHAPER_MZV = 2,
  /*
   Three impulses over a period: at the frequency 5 % of the vibration is left, and no more than that from 0.82 to 1.18 of it.
   */
  SPLINEWAY_SHAPER_EI = 3,
  /*
   A half wave over one and a half periods: what lies above the frequency is damped too.
   */
  SPLINEWAY_SHAPER_SMOOTH = 4,
} splineway_shaper;

/*
 Limits of an axis.
 */
typedef struct {
  /*
   mm/s (degrees/s on a rotary axis).
   */
  float velocity;
  /*
   mm/s2.
   */
  float acceleration;
  /*
   mm/s3.
   */
  float jerk;
  /*
   Whether it turns: its feed does not count as way.
   */
  bool rotary;
} splineway_axis;

/*
 Limits of an axis for stops that must be short.
 */
typedef struct {
  /*
   mm/s2; less than that of the axis at the time, as 0, says nothing.
   */
  float acceleration;
  /*
   mm/s3; the same.
   */
  float jerk;
} splineway_stop_limits;

/*
 How far an axis may go.
 */
typedef struct {
  /*
   Least position, nm; `INT64_MIN`: none.
   */
  int64_t least;
  /*
   Greatest position, nm; `INT64_MAX`: none.
   */
  int64_t greatest;
} splineway_travel;

/*
 An axis that vibrates, and what is to be done about it: all zeros, nothing.
 */
typedef struct {
  /*
   A number of `splineway_shaper`. Other than `NONE` it needs a library with the feature `shaping`.
   */
  uint32_t kind;
  /*
   Frequency of the vibration, Hz, as it is seen (with its damping).
   */
  float frequency;
  /*
   Damping ratio of the vibration, 0 to 0.5; 0.05 to 0.1 as a rule.
   */
  float damping;
} splineway_shape;

/*
 A machine. Made by `splineway_config_init`, which says how large the header has it: a library of another
 size then touches nothing.
 */
typedef struct {
  /*
   Bytes of this structure in the header; not to be changed.
   */
  uint32_t size;
  /*
   `SPLINEWAY_AXES` of the header.
   */
  uint32_t axis_count;
  /*
   Limits of the axes.
   */
  splineway_axis axes[SPLINEWAY_AXES];
  /*
   Limits for `splineway_quick_hold` and `splineway_quick_abort`; none of their own unless they are set.
   */
  splineway_stop_limits stop[SPLINEWAY_AXES];
  /*
   Limits of travel; none unless they are set.
   */
  splineway_travel travel[SPLINEWAY_AXES];
  /*
   Input shaping; none unless it is set.
   */
  splineway_shape shape[SPLINEWAY_AXES];
  /*
   Servo cycle, s.
   */
  float cycle;
  /*
   Tolerance of blocks that name none, mm.
   */
  float tolerance;
  /*
   Time by which a plan is handed over before it takes effect, s: longer than a planning step takes.
   */
  float lead;
  /*
   How long a start from rest waits for the look-ahead to fill, s.
   */
  float start_delay;
  /*
   Most improvement steps of one planning step.
   */
  uint16_t iterations;
  /*
   Sweeps in which runs of short lines are smoothed.
   */
  uint16_t sweeps;
} splineway_config;

/*
 Storage of a core: opaque, and not to be moved once it is set up (it would no longer be ready).
 */
typedef struct {
  /*
   Not to be touched.
   */
  uint64_t words[SPLINEWAY_STORAGE_WORDS];
} splineway_core;

/*
 Where the axes should be at the end of a servo cycle.
 */
typedef struct {
  /*
   nm (1e-6 degrees on a rotary axis).
   */
  int64_t position[SPLINEWAY_AXES];
  /*
   mm/s.
   */
  float velocity[SPLINEWAY_AXES];
  /*
   mm/s2.
   */
  float acceleration[SPLINEWAY_AXES];
  /*
   Speed along the path, mm/s.
   */
  float path_speed;
  /*
   Tag of the block under way.
   */
  uint32_t tag;
  /*
   What the interpolator is doing.
   */
  splineway_activity activity;
} splineway_setpoint;

/*
 How the planner is.
 */
typedef struct {
  /*
   End point of the last block taken, nm; after an abort, where the machine stands.
   */
  int64_t end[SPLINEWAY_AXES];
  /*
   Blocks that have not been cut into cells yet.
   */
  uint32_t blocks_waiting;
  /*
   Nodes of the window that lie ahead of the motion.
   */
  uint32_t nodes_ahead;
  /*
   Whether there is no room for another block.
   */
  bool full;
  /*
   Plans handed over.
   */
  uint32_t plans;
  /*
   Plans that came too late; the one before went on.
   */
  uint32_t late;
  /*
   Stops because blocks did not come in time.
   */
  uint32_t starved;
  /*
   Stretches for which no motion was found at once.
   */
  uint32_t stuck;
} splineway_report;

/*
 A motor that follows several axes.
 */
typedef struct {
  /*
   How far it goes for one of each axis: mm, or degrees, each.
   */
  float factors[SPLINEWAY_AXES];
  /*
   mm/s.
   */
  float velocity;
  /*
   mm/s2.
   */
  float acceleration;
  /*
   mm/s3.
   */
  float jerk;
} splineway_motor;

/*
 An output that takes a value at a place of the program.
 */
typedef struct {
  /*
   A digital or an analogue one: a number of `splineway_output`.
   */
  uint32_t output;
  /*
   Its number.
   */
  uint8_t number;
  /*
   What it is to be: 0 or 1 of a digital one.
   */
  float value;
  /*
   With what: a number of `splineway_trigger`.
   */
  uint32_t trigger;
  /*
   How far behind that, mm; negative: before.
   */
  float distance;
  /*
   Or how long behind that, s; negative: before. One of the two is 0.
   */
  float time;
  /*
   Tag of the event at `REST`.
   */
  uint32_t tag;
} splineway_switch;

/*
 The power of a tool that works along the path.
 */
typedef struct {
  /*
   At the programmed feed.
   */
  float level;
  /*
   Whether it is in proportion to the speed along the path.
   */
  bool dynamic;
  /*
   The least of one in proportion to the speed, as long as the motion moves.
   */
  float least;
  /*
   The greatest.
   */
  float most;
} splineway_power;

/*
 An output has switched.
 */
typedef struct {
  /*
   Which.
   */
  splineway_output output;
  /*
   Its number.
   */
  uint8_t number;
  /*
   To what.
   */
  float value;
  /*
   When in the servo cycle that ends with the setpoint: 0 at its beginning, 1 at its end.
   */
  float fraction;
} splineway_switched;

/*
 How a block is run.
 */
typedef struct {
  /*
   mm/s; with a `duration` it does not count; 0 is a rapid: as fast as the axes can.
   */
  float feed;
  /*
   Seconds the block takes (inverse time); 0 if `feed` counts.
   */
  float duration;
  /*
   Greatest distance from the programmed path, mm; a number below 0: the machine's.
   */
  float tolerance;
  /*
   Whether to come to rest exactly on the end point.
   */
  bool exact_stop;
  /*
   The caller's mark; it comes back with the setpoints.
   */
  uint32_t tag;
} splineway_block;

/*
 A circle or helix.
 */
typedef struct {
  /*
   The plane's two axes.
   */
  uint32_t plane[2];
  /*
   Centre in these axes, nm.
   */
  int64_t centre[2];
  /*
   G2.
   */
  bool clockwise;
  /*
   Full turns beyond the first arrival.
   */
  uint16_t extra_turns;
} splineway_arc;

/*
 What came of a probe.
 */
typedef struct {
  /*
   How it ended.
   */
  splineway_probe_outcome outcome;
  /*
   Where the axes were when the input changed, where they came to rest if it did not, nm.
   */
  int64_t position[SPLINEWAY_AXES];
} splineway_probe_result;

/*
 How an axis is homed.
 */
typedef struct {
  /*
   Whether it is.
   */
  bool wanted;
  /*
   Axes of a lower number are homed before those of a higher one; those of the same at once.
   */
  uint8_t order;
  /*
   Speed of the first approach and of the ways back, mm/s; its sign says on which side the switch is.
   */
  float fast;
  /*
   Speed of the second approach, mm/s.
   */
  float slow;
  /*
   How far away the switch may be, nm: without an edge the axis ends there.
   */
  int64_t reach;
  /*
   How far it goes back from the switch, nm: more than the switch needs to open.
   */
  int64_t back;
  /*
   The coordinate of the edge, nm.
   */
  int64_t at;
  /*
   Whether the axis goes somewhere in the end.
   */
  bool parks;
  /*
   Where to, in the new coordinates, nm.
   */
  int64_t park;
} splineway_axis_home;

/*
 What came of homing, and with which axis.
 */
typedef struct {
  /*
   What came of it.
   */
  splineway_homing homing;
  /*
   The axis with which something has gone wrong.
   */
  uint32_t axis;
  /*
   What it was doing: 0 done, 1 waiting for others, 2 leaving its switch, 3 seeking it, 4 backing off, 5 approaching it slowly,
   6 on its way from it.
   */
  uint32_t phase;
} splineway_home_result;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Fills in sensible settings: 1 ms servo cycle, 0.01 mm tolerance, and the same limits for every axis,
 mm/s, mm/s2 and mm/s3. To be called as `splineway_config_init(config, velocity, acceleration, jerk)`, which
 passes the header's size of a configuration, `bytes`, and its version with the size of an enumeration (which compilers choose, and
 `-fshort-enums` does), `interface`: if they are not the library's, nothing is written.

 Context: any.
 */
splineway_result splineway_config_init_sized(splineway_config *config,
                                             size_t bytes,
                                             uint32_t interface,
                                             float velocity,
                                             float acceleration,
                                             float jerk);

/*
 Sets a core up in `storage` of `bytes` bytes, at rest at `start` (nm, one number per axis). What was there is
 forgotten, if this is refused, too. Not while an interrupt may call [`splineway_tick`] on the same storage.

 Context: background, while no interrupt uses this core.
 */
splineway_result splineway_init(splineway_core *storage,
                                size_t bytes,
                                const splineway_config *config,
                                const int64_t *start);

/*
 Changes the limits of travel, one pair per axis: they hold for every block that is pushed from now on. `CONFIG`, and
 nothing has changed, if one is out of its range or a greatest position is less than the least.

 Context: background.
 */
splineway_result splineway_set_travel(splineway_core *core,
                                      const splineway_travel *axes);

/*
 Changes the limits of the axes, one set per axis: they bound every block that is pushed from now on. What has been taken keeps
 those it was taken with. `FULL`, and nothing has changed: limits have changed four times between the motion and the last
 block, a curve is still being taken, or a jog is on; poll, and set them again. `CONFIG`: one is out of its range.

 Context: background.
 */
splineway_result splineway_set_limits(splineway_core *core,
                                      const splineway_axis *axes);

/*
 Says that no more blocks come for now.

 Context: background.
 */
splineway_result splineway_finish(splineway_core *core);

/*
 Does a slice of what is to be done now. To be called in the background, again and again; at once if it says
 `PLANNING`.

 Context: background.
 */
splineway_progress splineway_poll(splineway_core *core);

/*
 Polls until nothing can be done before the interpolator has moved on or blocks come, or until a plan was handed
 over: for tests and simulations in which planning takes no time.

 Context: background.
 */
splineway_progress splineway_settle(splineway_core *core);

/*
 The caller knows that an abort has dropped everything. True: it is complete, and blocks are taken again,
 from where the machine stands (`end` of `splineway_status`). False, and nothing has changed: there is none,
 or `splineway_poll` has not said `ABORTED` since the last was asked for.

 Context: background.
 */
bool splineway_acknowledge_abort(splineway_core *core);

/*
 One servo cycle: writes where the axes should be at its end. To be called by the servo interrupt.

 Context: servo interrupt.
 */
splineway_result splineway_tick(splineway_core *core, splineway_setpoint *setpoint);

/*
 How things are.

 Context: background.
 */
splineway_result splineway_status(splineway_core *core, splineway_report *status);

/*
 What a result means, in words that stay valid. Any number may be given.

 Context: any.
 */
const char *splineway_result_text(int32_t result);

/*
 Ends a jog: every axis brakes as hard as its limits allow. From any context, as the commands of an operator.

 Context: any.
 */
splineway_result splineway_jog_cancel(splineway_core *core);

/*
 Feed hold: brake as hard as the limits allow, and rest on the path.

 Context: any.
 */
splineway_result splineway_hold(splineway_core *core);

/*
 The same by the limits for stops. If the motion brakes already, it goes on as it does.

 Context: any.
 */
splineway_result splineway_quick_hold(splineway_core *core);

/*
 Ends a hold or a stop; in single block mode, runs the next block.
 It is meant for a rest or a pause from the tick on that shows it, polled or not; before that it is for the motion.

 Context: any.
 */
splineway_result splineway_resume(splineway_core *core);

/*
 Finish the block under way, then rest until resumed. If the motion is too fast to rest at its end, the first block is finished at whose end it
 can; where a corner is rounded, the end of a block is the middle of the rounding. Where no motion to such an end is found in time, the machine
 brakes as for a hold, and goes on from rest to the end of that block.

 Context: any.
 */
splineway_result splineway_stop(splineway_core *core);

/*
 Brake, and drop everything that has not been run. No block is taken until `splineway_acknowledge_abort`.

 Context: any.
 */
splineway_result splineway_abort(splineway_core *core);

/*
 The same by the limits for stops.

 Context: any.
 */
splineway_result splineway_quick_abort(splineway_core *core);

/*
 Feed override, 0 to 200 per cent.

 Context: any.
 */
splineway_result splineway_feed_override(splineway_core *core, uint16_t percent);

/*
 Override of rapids, 0 to 100 per cent.

 Context: any.
 */
splineway_result splineway_rapid_override(splineway_core *core, uint16_t percent);

/*
 Single block mode: rest at the end of every block until resumed.

 Context: any.
 */
splineway_result splineway_single_block(splineway_core *core, bool on);

/*
 Jogs: every axis by itself comes to a velocity (mm/s) and keeps it for some seconds, unless it is asked for again, or up to
 its limit of travel. From rest with nothing to run, or from a hold within a program; the next `splineway_poll` plans it.
 `RUNNING` if a program runs.

 Context: background.
 */
splineway_result splineway_jog_velocity(splineway_core *core,
                                        const float *velocity,
                                        float seconds);

/*
 Jogs by a distance per axis (nm), at a speed along the line (mm/s). Steps add up.

 Context: background.
 */
splineway_result splineway_jog_step(splineway_core *core, const int64_t *by, float feed);

/*
 Jogs to a point (nm), from rest along the straight line, at a speed along it (mm/s).

 Context: background.
 */
splineway_result splineway_jog_to(splineway_core *core, const int64_t *to, float feed);

/*
 Jogs back to where the program was held; from there `splineway_resume` goes on. `NO_PROGRAM` if none is held.

 Context: background.
 */
splineway_result splineway_jog_back(splineway_core *core,
                                    float feed);

/*
 The motors of the machine, `count` of them, 8 at most, at rest with nothing to run: after `splineway_init`, as a rule. They keep their
 limits from then on, and `splineway_set_limits` leaves them as they are. `RUNNING` if the machine is not at rest; `CONFIG`, and nothing
 has changed, if a limit or a factor is out of its range, an axis could move with others without a motor, or
 axes are shaped unlike each other.

 Context: background.
 */
splineway_result splineway_set_motors(splineway_core *core,
                                      const splineway_motor *motors,
                                      uint32_t count);

/*
 Where `count` motors are with the axes at `axes` (one number per axis, nm): in `positions`, nm. From any context; the position of a
 setpoint is what a drive is to be given.

 Context: any.
 */
splineway_result splineway_motor_positions(const splineway_motor *motors,
                                           uint32_t count,
                                           const int64_t *axes,
                                           int64_t *positions);

/*
 Has an output switch at or about the end of the block that was pushed last. `FULL`: poll, and push the same switch again.

 Context: background.
 */
splineway_result splineway_push_switch(splineway_core *core,
                                       const splineway_switch *switch_);

/*
 The power of the blocks that are pushed from now on. One that is the same at every speed is on in dwells and events behind such a block
 too, if it is not taken back before they are pushed. `ABORTED` from an abort on until it is acknowledged.

 Context: background.
 */
splineway_result splineway_set_power(splineway_core *core,
                                     const splineway_power *wanted);

/*
 The same, and at rest, behind all that was pushed, before all that will be: one that is the same at every speed is on in
 the dwells that follow.

 Context: background.
 */
splineway_result splineway_push_power(splineway_core *core,
                                      const splineway_power *wanted,
                                      uint32_t tag);

/*
 `splineway_tick`, and what has switched in that servo cycle, in `list`, which has room for `room`: 52 is enough for
 all. `count` is how many there are, also beyond the room; `level` the power at the end of the cycle. Where setpoints are shaped, both
 belong to where the machine is: to the setpoint that is written.

 Context: servo interrupt.
 */
splineway_result splineway_tick_outputs(splineway_core *core,
                                        splineway_setpoint *setpoint,
                                        splineway_switched *list,
                                        uint32_t room,
                                        uint32_t *count,
                                        float *level);

/*
 Adds a straight line to `to` (nm).

 Context: background.
 */
splineway_result splineway_push_line(splineway_core *core,
                                     const int64_t *to,
                                     const splineway_block *options);

/*
 Adds a circular arc or helix to `to` (nm) about a centre (nm) in the plane of two axes, in the order
 in which a quarter turn takes the first to the second: G17 is 0, 1. The same end as start in the plane is
 a full circle; `extra_turns` are added.

 Context: background.
 */
splineway_result splineway_push_arc(splineway_core *core,
                                    const int64_t *to,
                                    const splineway_arc *arc,
                                    const splineway_block *options);

/*
 Adds a cubic curve (a span of a spline) to `to` by its two Bezier points between (nm).

 Context: background.
 */
splineway_result splineway_push_cubic(splineway_core *core,
                                      const int64_t *first,
                                      const int64_t *second,
                                      const int64_t *to,
                                      const splineway_block *options);

/*
 Adds a standstill of some seconds.

 Context: background.
 */
splineway_result splineway_push_dwell(splineway_core *core, float seconds, uint32_t tag);

/*
 Adds an event: the motion comes to rest, and for one servo cycle the setpoint has the activity `EVENT` and
 this tag. With `pause` the machine then rests until `splineway_resume`.

 Context: background.
 */
splineway_result splineway_push_event(splineway_core *core,
                                      bool pause,
                                      uint32_t tag);

/*
 Tells the level of an input, `fraction` of a servo cycle after the last `splineway_tick`: to be called from the interrupt of its
 edges, from any context, and once at the start. `number` is the index of an axis for its home switch, -1 for the probe; `INPUT`
 if it is neither. Where the fraction is read while a tick is due that has not come, it is one more; where one came after it was read, one less. What
 is no number counts as -1.

 Context: any.
 */
splineway_result splineway_input(splineway_core *core,
                                 int32_t number,
                                 bool closed,
                                 float fraction);

/*
 Probes: a straight move to `to` (nm) at a feed (mm/s) that ends early when an input closes, or opens. From rest with nothing to run;
 `RUNNING`, `HELD` or `ABORTED` else, and `INPUT` if the input is as it would be at the end. `splineway_probed` says what came of it;
 until then no block is taken.

 Context: background.
 */
splineway_result splineway_probe(splineway_core *core,
                                 const int64_t *to,
                                 float feed,
                                 int32_t number,
                                 bool closes);

/*
 What came of the last probe, once: afterwards, and as long as it is not over, the outcome is `NONE`.

 Context: background.
 */
splineway_result splineway_probed(splineway_core *core,
                                  splineway_probe_result *result);

/*
 How far a probe in a direction (one number per axis, of any length) at a feed (mm/s) goes on after its edge at the worst, mm: where the
 feed has been reached, and anywhere.

 Context: background.
 */
splineway_result splineway_probe_overshoot(splineway_core *core,
                                           float feed,
                                           const float *direction,
                                           float *at_feed,
                                           float *most);

/*
 Homes axes, one `splineway_axis_home` per axis: each that has `wanted` goes to its switch, back, to it again slowly, and the
 coordinate of its edge then is `at`. Refused as `splineway_probe` is. `splineway_homed` says what came of it.

 Context: background.
 */
splineway_result splineway_home(splineway_core *core,
                                const splineway_axis_home *axes);

/*
 What came of the last `splineway_home` or `splineway_set_position`, once: afterwards, and as long as it is not over, it is `NONE`.

 Context: background.
 */
splineway_result splineway_homed(splineway_core *core,
                                 splineway_home_result *result);

/*
 Sets the coordinates (nm) of where the machine stands, at rest with nothing to run. Setpoints are the new ones from the one with the
 activity `SET` on, and `splineway_homed` says `DONE`.

 Context: background.
 */
splineway_result splineway_set_position(splineway_core *core,
                                        const int64_t *to);

/*
 By how much the setpoints are behind the program because they are shaped, s. Outputs in time with the path are behind with them:
 `splineway_tick_outputs`. Of a library with the feature `shaping`.

 Context: any.
 */
splineway_result splineway_shaper_delay(splineway_core *core,
                                        float *seconds);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SPLINEWAY_H */
