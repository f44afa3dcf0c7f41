//! The image.

use core::convert::Infallible;
use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m_rt::entry;
use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_hal::pwm;
use splineway::block::centre_from_radius;
use splineway::c;
use splineway::output::{Analogue, Drive, EdgeTimes, PositionLoop, Scale, StepDir, StepTiming};
use splineway::{
    AxisLimits, Block, Config, Coord, CornerMode, Interpolator, Limits, Link, Planner, Setpoint,
    Turn,
};
use splineway_proof as _;

/// A pin, as far as a compiler can know.
struct Pin(&'static AtomicU32);

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.store(0, Relaxed);
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.store(1, Relaxed);
        Ok(())
    }
}

impl pwm::ErrorType for Pin {
    type Error = Infallible;
}

impl pwm::SetDutyCycle for Pin {
    fn max_duty_cycle(&self) -> u16 {
        black_box(1000)
    }
    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.0.store(u32::from(duty), Relaxed);
        Ok(())
    }
}

static PORT: AtomicU32 = AtomicU32::new(0);
static mut CORE: c::splineway_core = c::splineway_core { words: [0; c::SPLINEWAY_STORAGE_WORDS] };

/// One memory for the core from Rust and the one from C: there is none for two, and neither ever runs.
const _: () = assert!(size_of::<Link<f32, 3>>() <= size_of::<c::splineway_core>());

/// Steps and a laser, as a drive.
struct Axis(StepDir<Pin, Pin>, Analogue<Pin, f32>, PositionLoop<f32>);

impl Drive<f32, 3> for Axis {
    type Error = ();
    fn drive(&mut self, setpoint: &Setpoint<f32, 3>) -> Result<(), ()> {
        let left = self.0.begin(setpoint.position(black_box(0)));
        for _ in 0..black_box(100) {
            self.0.tick().map_err(drop)?;
        }
        let asked = self.2.velocity(setpoint.path_speed, black_box(0.1)).map_err(drop)?;
        self.1.set(asked).map_err(drop)?;
        if left == 0 { Ok(()) } else { Err(()) }
    }
}

fn axis() -> Option<Axis> {
    let scale = Scale::new(black_box(400), black_box(1_000_000)).ok()?;
    let drive = EdgeTimes { pulse: 1000, pause: 1000, setup: 1000, hold: 1000 };
    let timing = StepTiming::from_ns(black_box(100_000), black_box(1000), black_box(drive));
    let (start, most) = (black_box(Coord::ZERO), black_box(timing.most_steps()));
    let steps = StepDir::new(Pin(&PORT), Pin(&PORT), scale, timing, start, most).ok()?;
    black_box(steps.steps());
    let laser = Analogue::unipolar(Pin(&PORT), black_box(100.0));
    let position = PositionLoop { gain: black_box(20.0), most_error: black_box(0.5) };
    Some(Axis(steps, laser, position))
}

fn config() -> Option<Config<f32, 3>> {
    let axis = AxisLimits {
        rotary: black_box(false),
        ..AxisLimits::linear(black_box(200.0), black_box(2000.0), black_box(50_000.0))
    };
    let mut config = black_box(Config::new(Limits::new([axis; 3]).ok()?));
    config.corner = black_box(CornerMode::Paper { lambda: 0.3 });
    config.check().ok()?;
    Some(config)
}

/// A controller's loop with drives.
fn drives(
    planner: &mut Planner<'_, f32, 3>,
    interpolator: &mut Interpolator<'_, f32, 3>,
    config: &Config<f32, 3>,
) -> Option<()> {
    let mut drive = axis()?;
    loop {
        black_box(planner.poll());
        let setpoint = interpolator.tick();
        black_box(drive.drive(&setpoint)).ok()?;
        black_box(crate::line::controller(planner, &setpoint));
        crate::line::background(planner, &setpoint);
        crate::grbl::background(planner, &setpoint, config);
    }
}

/// Blocks checked before a program is run.
fn checks(config: &Config<f32, 3>) -> Option<()> {
    let block: Block<f32, 3> = black_box(Block::line([Coord::ZERO; 3], 1.0, 1));
    block.check(&black_box([Coord::ZERO; 3]), config).ok()?;
    let at = black_box((Coord::ZERO, Coord::from_mm(black_box(1.0)).ok()?));
    black_box(centre_from_radius(at, at, black_box(2.0), black_box(Turn::Clockwise)).ok()?);
    Some(())
}

/// Outputs in time with the path.
unsafe fn outputs(core: *mut c::splineway_core, setpoint: *mut c::splineway_setpoint) {
    let switch = black_box(c::splineway_switch {
        output: 0,
        number: 1,
        value: 1.0,
        trigger: 0,
        distance: 0.0,
        time: -0.1,
        tag: 1,
    });
    let power = black_box(c::splineway_power { level: 1.0, dynamic: true, least: 0.0, most: 1.0 });
    let mut list = [const { core::mem::MaybeUninit::<c::splineway_switched>::uninit() }; 4];
    let (mut count, mut level) = (0, 0.0);
    // SAFETY: pointers to what is there, from one context.
    unsafe {
        black_box(c::splineway_push_switch(core, &raw const switch));
        black_box(c::splineway_set_power(core, &raw const power));
        black_box(c::splineway_push_power(core, &raw const power, black_box(1)));
        let list = list.as_mut_ptr().cast::<c::splineway_switched>();
        let room = black_box(4);
        let (count, level) = (&raw mut count, &raw mut level);
        black_box(c::splineway_tick_outputs(core, setpoint, list, room, count, level));
    }
    black_box((list, count, level));
}

/// Everything a C program may call.
fn interface() {
    let core = &raw mut CORE;
    let mut config = core::mem::MaybeUninit::uninit();
    let to = black_box([0; c::SPLINEWAY_AXES]);
    let options = black_box(c::splineway_block {
        feed: 1.0,
        duration: 0.0,
        tolerance: -1.0,
        exact_stop: false,
        tag: 1,
    });
    let arc = black_box(c::splineway_arc {
        plane: [0, 1],
        centre: [0, 0],
        clockwise: true,
        extra_turns: 0,
    });
    let mut setpoint = core::mem::MaybeUninit::uninit();
    let mut report = core::mem::MaybeUninit::uninit();
    // SAFETY: pointers to what is there, from one context.
    unsafe {
        let (bytes, version) =
            (black_box(size_of::<c::splineway_config>()), black_box(c::SPLINEWAY_INTERFACE));
        let limits = black_box([200.0, 2000.0, 50_000.0]);
        let config: *mut c::splineway_config = config.as_mut_ptr();
        c::splineway_config_init_sized(config, bytes, version, limits[0], limits[1], limits[2]);
        black_box(c::splineway_init(core, size_of::<c::splineway_core>(), config, to.as_ptr()));
        let travel = black_box(c::splineway_travel { least: -1, greatest: 1 });
        let travel = [travel; c::SPLINEWAY_AXES];
        black_box(c::splineway_set_travel(core, travel.as_ptr()));
        black_box(c::splineway_set_limits(core, (&raw const (*config).axes).cast()));
        black_box((c::splineway_quick_hold(core), c::splineway_quick_abort(core)));
        black_box(c::splineway_push_line(core, to.as_ptr(), &raw const options));
        black_box(c::splineway_push_arc(core, to.as_ptr(), &raw const arc, &raw const options));
        let p = to.as_ptr();
        black_box(c::splineway_push_cubic(core, p, p, p, &raw const options));
        black_box(c::splineway_push_dwell(core, black_box(1.0), 1));
        black_box(c::splineway_push_event(core, black_box(true), 1));
        let velocity = black_box([1.0; c::SPLINEWAY_AXES]);
        black_box(c::splineway_jog_velocity(core, velocity.as_ptr(), black_box(0.5)));
        black_box((c::splineway_jog_step(core, p, 1.0), c::splineway_jog_to(core, p, 1.0)));
        black_box((c::splineway_jog_back(core, black_box(1.0)), c::splineway_jog_cancel(core)));
        outputs(core, setpoint.as_mut_ptr());
        black_box(c::splineway_input(core, black_box(-1), black_box(true), black_box(0.5)));
        black_box(c::splineway_probe(core, p, black_box(1.0), black_box(-1), black_box(true)));
        let mut probed = core::mem::MaybeUninit::uninit();
        black_box(c::splineway_probed(core, probed.as_mut_ptr()));
        let mut told = black_box([0.0; 2]);
        let [at_feed, most] = told.each_mut().map(core::ptr::from_mut);
        black_box(c::splineway_probe_overshoot(core, 1.0, velocity.as_ptr(), at_feed, most));
        let axis = c::splineway_axis_home {
            wanted: true,
            order: 0,
            fast: 10.0,
            slow: 1.0,
            reach: 1_000_000,
            back: 1_000,
            at: 0,
            parks: true,
            park: 5,
        };
        let axes = black_box([axis; c::SPLINEWAY_AXES]);
        black_box(c::splineway_home(core, axes.as_ptr()));
        let mut homed = core::mem::MaybeUninit::uninit();
        black_box(c::splineway_homed(core, homed.as_mut_ptr()));
        black_box(c::splineway_set_position(core, p));
        black_box(c::splineway_finish(core));
        black_box(c::splineway_poll(core));
        black_box(c::splineway_acknowledge_abort(core));
        black_box(c::splineway_tick(core, setpoint.as_mut_ptr()));
        black_box(c::splineway_status(core, report.as_mut_ptr()));
        black_box((c::splineway_hold(core), c::splineway_resume(core), c::splineway_stop(core)));
        black_box((c::splineway_abort(core), c::splineway_single_block(core, black_box(true))));
        black_box(c::splineway_feed_override(core, black_box(50)));
        black_box(c::splineway_rapid_override(core, black_box(50)));
    }
    black_box(c::splineway_result_text(black_box(3)));
}

fn run() -> Option<()> {
    let config = config()?;
    // SAFETY: all zeros are an empty link, and it has room (see above).
    let link = unsafe { &mut *(&raw mut CORE).cast::<Link<f32, 3>>() };
    let (mut planner, mut interpolator) = link.split(config, black_box([Coord::ZERO; 3])).ok()?;
    checks(&config)?;
    interface();
    black_box(crate::curves::all().is_ok());
    black_box(crate::line::host(planner.controls()));
    black_box(crate::text::read(black_box(b"G1 X1")));
    drives(&mut planner, &mut interpolator, &config)
}

#[entry]
fn main() -> ! {
    black_box(run());
    loop {
        black_box(());
    }
}
