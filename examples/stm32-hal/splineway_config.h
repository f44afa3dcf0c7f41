/* Sizes and features of the motion core: read by splineway.h and by the build of the library. */
#ifndef SPLINEWAY_CONFIG_H
#define SPLINEWAY_CONFIG_H

#define SPLINEWAY_AXES 3
/* Blocks of the look-ahead. */
#define SPLINEWAY_BLOCKS 16
/* Nodes of the planning window, 48 at least: the more, the longer the look-ahead. */
#define SPLINEWAY_NODES 64
/* Features: outputs in time with the path, motors that follow several axes, input shaping. */
#define SPLINEWAY_OUTPUTS 0
#define SPLINEWAY_KINEMATICS 0
#define SPLINEWAY_SHAPING 0

#endif
