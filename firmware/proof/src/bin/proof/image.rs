//! The image.

use core::hint::black_box;
use cortex_m_rt::entry;
use splineway::{
    Activity, AxisLimits, Block, Config, ConfigError, Controls, Coord, Feed, Interpolator, Limits,
    Link, Motion, Planner, Progress, PushError, Setpoint, Turn,
};
#[cfg(feature = "kinematics")]
use splineway::{Kinematics, Linear};
use splineway_proof as _;

/// The entry points of a machine with a number of axes, under names that the measurement knows.
macro_rules! machine {
    ($axes:literal, $blocks:literal, $nodes:literal, $link:ident, $split:ident, $tick:ident, $poll:ident, $push:ident, $motors:ident, $run:ident) => {
        static mut $link: Link<f32, $axes, $blocks, $nodes> = Link::new();

        #[inline(never)]
        #[unsafe(no_mangle)]
        fn $split<'a>(
            link: &'a mut Link<f32, $axes, $blocks, $nodes>,
            config: &Config<f32, $axes>,
            start: &[Coord; $axes],
        ) -> Result<
            (Planner<'a, f32, $axes, $blocks, $nodes>, Interpolator<'a, f32, $axes>),
            ConfigError,
        > {
            link.split(*config, *start)
        }

        #[inline(never)]
        #[unsafe(no_mangle)]
        fn $tick(interpolator: &mut Interpolator<'_, f32, $axes>) -> Setpoint<f32, $axes> {
            interpolator.tick()
        }

        #[inline(never)]
        #[unsafe(no_mangle)]
        fn $poll(planner: &mut Planner<'_, f32, $axes, $blocks, $nodes>) -> Progress {
            planner.poll()
        }

        #[inline(never)]
        #[unsafe(no_mangle)]
        fn $push(
            planner: &mut Planner<'_, f32, $axes, $blocks, $nodes>,
            block: &Block<f32, $axes>,
        ) -> Result<(), PushError> {
            planner.push(block)
        }

        #[cfg(feature = "kinematics")]
        #[inline(never)]
        #[unsafe(no_mangle)]
        fn $motors(
            motors: &Linear<f32, $axes, $axes>,
            axes: &Setpoint<f32, $axes>,
        ) -> Setpoint<f32, $axes> {
            motors.setpoint(axes)
        }

        fn $run() -> Option<()> {
            let axis = AxisLimits {
                rotary: black_box(false),
                ..AxisLimits::linear(black_box(200.0), black_box(2000.0), black_box(50_000.0))
            };
            let mut config = black_box(Config::new(Limits::new([axis; $axes]).ok()?));
            config.tolerance = black_box(0.01);
            #[cfg(feature = "kinematics")]
            let belts = black_box(Linear::new(*Linear::core_xy().factors()).ok()?);
            #[cfg(feature = "kinematics")]
            {
                config.limits = config.limits.with_motors(&belts, black_box([axis; $axes])).ok()?;
            }
            // SAFETY: called once, and nothing else knows the link.
            let link = unsafe { &mut *(&raw mut $link) };
            let start = black_box([Coord::ZERO; $axes]);
            let (mut planner, mut interpolator) = $split(link, &config, &start).ok()?;
            let to = black_box([Coord::from_nm(black_box(1000)).ok()?; $axes]);
            let (plane, centre) = (black_box((0, 1)), black_box((to[0], to[1])));
            let turn = black_box(Turn::Clockwise);
            let extra_turns = black_box(0);
            let motion = match black_box(0) {
                0 => Motion::Line { to },
                1 => Motion::Arc { to, plane, centre, turn, extra_turns },
                2 => Motion::Cubic { controls: black_box([to, to]), to },
                3 => Motion::Event { pause: black_box(true) },
                _ => Motion::Dwell { seconds: black_box(1.0) },
            };
            let block = black_box(Block {
                motion,
                feed: black_box(Feed::Rapid),
                tolerance: black_box(None),
                exact_stop: black_box(false),
                tag: black_box(0),
            });
            black_box($push(&mut planner, &block)).ok()?;
            planner.finish();
            operate(planner.controls());
            loop {
                black_box($poll(&mut planner));
                let setpoint = black_box($tick(&mut interpolator));
                #[cfg(feature = "kinematics")]
                black_box($motors(&belts, &setpoint));
                black_box((planner.counters(), planner.end(), planner.nodes_ahead()));
                black_box((planner.is_full(), planner.blocks_waiting()));
                black_box(planner.acknowledge_abort());
                let axis = black_box(0);
                black_box((setpoint.position_nm(axis), setpoint.position_mm(axis)));
                black_box(setpoint.path_mm());
                if setpoint.activity == Activity::Idle {
                    return Some(());
                }
            }
        }
    };
}

machine!(3, 16, 64, LINK_3, split_3, tick_3, poll_3, push_3, motors_3, run_3);
// Smaller: both must fit.
machine!(6, 8, 56, LINK_6, split_6, tick_6, poll_6, push_6, motors_6, run_6);

/// Motors of other machines.
#[cfg(feature = "kinematics")]
fn others() -> Option<()> {
    let skewed = Linear::<f32, 3, 3>::skew(black_box(0), black_box(1), black_box(0.01)).ok()?;
    let gantry = Linear::<f32, 3, 4>::gantry(black_box(1)).ok()?;
    let at = black_box([Coord::ZERO; 3]);
    black_box((skewed.positions(&at), gantry.positions(&at), Linear::<f32, 3, 3>::direct()));
    Some(())
}

/// Every command of an operator.
fn operate(controls: Controls<'_>) {
    controls.hold();
    controls.resume();
    controls.stop();
    controls.abort();
    controls.feed_override(black_box(50));
    controls.rapid_override(black_box(50));
    controls.single_block(black_box(true));
}

#[entry]
fn main() -> ! {
    black_box((run_3(), run_6()));
    #[cfg(feature = "kinematics")]
    black_box(others());
    loop {
        black_box(());
    }
}
