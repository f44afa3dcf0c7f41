//! Output drivers: every edge is counted, and timed.

use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_hal_mock::eh1::pwm::{Mock, Transaction};
use proptest::prelude::*;
use splineway::output::{
    Analogue, Drive, EdgeTimes, PositionLoop, Scale, StepDir, StepError, StepTiming,
};
use splineway::{Activity, AxisLimits, Block, Config, Coord, Limits, Link, Progress, Setpoint};
use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::rc::Rc;

/// Edges of a pin: tick and level.
#[derive(Clone, Default)]
struct Recorder {
    now: Rc<Cell<u64>>,
    level: Rc<Cell<bool>>,
    edges: Rc<RefCell<Vec<(u64, bool)>>>,
}

impl Recorder {
    fn set(&self, level: bool) {
        if self.level.replace(level) != level {
            self.edges.borrow_mut().push((self.now.get(), level));
        }
    }
}

impl ErrorType for Recorder {
    type Error = Infallible;
}

impl OutputPin for Recorder {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set(false);
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set(true);
        Ok(())
    }
}

/// Times of a drive, ns: of a pulse and a pause, of a change of direction.
fn edges(pulse: u32, turn: u32) -> EdgeTimes {
    EdgeTimes { pulse, pause: pulse, setup: turn, hold: turn }
}

/// An axis with recorders on its pins.
struct Bench {
    axis: StepDir<Recorder, Recorder>,
    timing: StepTiming,
    now: Rc<Cell<u64>>,
    step: Recorder,
    dir: Recorder,
}

impl Bench {
    fn new(scale: Scale, timing: StepTiming, start: Coord, most: u32) -> Self {
        let now = Rc::new(Cell::new(0));
        let pin = || Recorder { now: now.clone(), ..Recorder::default() };
        let (step, dir) = (pin(), pin());
        let axis = StepDir::new(step.clone(), dir.clone(), scale, timing, start, most).unwrap();
        Self { axis, timing, now, step, dir }
    }

    /// A servo cycle; gives the steps left over from the one before.
    fn cycle(&mut self, setpoint: Coord) -> u32 {
        self.cycle_of(setpoint, self.timing.ticks)
    }

    /// One that is shorter or longer than it should be.
    fn cycle_of(&mut self, setpoint: Coord, ticks: u32) -> u32 {
        let left = self.axis.begin(setpoint);
        for _ in 0..ticks {
            self.now.set(self.now.get() + 1);
            self.axis.tick().unwrap();
        }
        left
    }

    /// Judges every edge; gives the net count of steps.
    fn judge(&self) -> i64 {
        let StepTiming { pulse, pause, setup, hold, .. } = self.timing;
        let (steps, dirs) = (self.step.edges.borrow(), self.dir.edges.borrow());
        let mut count = 0;
        for (k, &(time, level)) in steps.iter().enumerate() {
            assert_eq!(level, k % 2 == 0);
            if k > 0 {
                let least = u64::from(if level { pause } else { pulse });
                assert!(time - steps[k - 1].0 >= least, "edges at {} and {time}", steps[k - 1].0);
            }
            let turn = dirs.iter().take_while(|edge| edge.0 <= time).last();
            if level {
                count += if turn.is_some_and(|edge| edge.1) { -1 } else { 1 };
                if let Some(turn) = turn {
                    assert!(time - turn.0 >= u64::from(setup), "set-up at {time}");
                }
            } else if let Some(next) = dirs.iter().find(|edge| edge.0 >= time) {
                assert!(next.0 - time >= u64::from(hold), "hold at {time}");
            }
        }
        // No change of direction while a pulse is on.
        for &(time, _) in dirs.iter() {
            let before = steps.iter().take_while(|edge| edge.0 <= time).last();
            assert!(before.is_none_or(|edge| !edge.1), "direction changes in a pulse at {time}");
        }
        count
    }
}

proptest! {
    /// Any walk that keeps to the limit is followed to the step, at the end of every cycle.
    #[test]
    fn any_walk_is_followed_step_by_step(
        pulse in 1u32..6, pause in 1u32..6, setup in 1u32..8, hold in 1u32..8, ticks in 1u32..120,
        shares in prop::collection::vec(-1.0f64..1.0, 1..80),
        full in any::<bool>(),
    ) {
        let timing = StepTiming { ticks, pulse, pause, setup, hold };
        let most = timing.most_steps();
        let scale = Scale::new(400, 1_000_000).unwrap();
        let mut bench = Bench::new(scale, timing, Coord::ZERO, most);
        let mut target = 0;
        for share in shares {
            let share = if full { share.signum() } else { share };
            target += (share * f64::from(most)) as i64;
            // A step is 2500 nm.
            let left = bench.cycle(Coord::from_nm(target * 2500).unwrap());
            prop_assert_eq!(left, 0);
            prop_assert_eq!(bench.axis.steps(), target);
        }
        // Any pulse ends.
        bench.cycle(Coord::from_nm(target * 2500).unwrap());
        prop_assert_eq!(bench.judge(), target);
    }

    /// Steps are the rounded position, whatever the scale.
    #[test]
    fn steps_are_rounded_positions(steps in 1u32..2_000_000, nm in 1u32..100_000_000, raw in any::<i64>()) {
        let raw = raw >> 4; // +-5.7e5 mm
        let scale = Scale::new(steps, nm).unwrap();
        let exact = i128::from(raw) * i128::from(steps) * 2;
        let per = i128::from(nm) * 1_000_000;
        let wanted = (exact + per).div_euclid(2 * per);
        let rest = (exact + per).rem_euclid(2 * per);
        let found = i128::from(scale.steps(Coord::from_raw(raw)));
        // Within a millionth of a step of the middle either is right.
        let tie = rest.min(2 * per - rest) < per / 500_000 + 1;
        prop_assert!(found == wanted || (tie && (found - wanted).abs() == 1), "{found} {wanted}");
    }
}

/// A jump that no motion makes is caught up with, not lost, and reported.
#[test]
fn what_cannot_be_followed_is_owed_and_told() {
    let timing = StepTiming { ticks: 40, pulse: 2, pause: 2, setup: 2, hold: 2 };
    let scale = Scale::new(1000, 1_000_000).unwrap();
    let mut bench = Bench::new(scale, timing, Coord::ZERO, timing.most_steps());
    let far = Coord::from_nm(100_000).unwrap(); // 100 steps
    assert_eq!(bench.cycle(far), 0);
    assert!(bench.cycle(far) > 0);
    for _ in 0..20 {
        bench.cycle(far);
    }
    assert_eq!((bench.axis.steps(), bench.judge()), (100, 100));
}

proptest! {
    /// Timer ticks that are lost, and servo cycles that are late: no step that was not asked for, every one
    /// that is missing is told, and the axis is never faster than it may be.
    #[test]
    fn lost_ticks_and_late_cycles_are_told_and_made_up_for(
        cycles in prop::collection::vec((-10i64..=10, 0u32..250), 1..60),
    ) {
        let timing = StepTiming { ticks: 100, pulse: 1, pause: 2, setup: 3, hold: 2 };
        let scale = Scale::new(1, 1000).unwrap();
        let mut bench = Bench::new(scale, timing, Coord::ZERO, 10);
        let mut target = 0;
        for (step, ticks) in cycles {
            let (before, behind) = (bench.axis.steps(), target - bench.axis.steps());
            target += step;
            let told = bench.cycle_of(Coord::from_nm(target * 1000).unwrap(), ticks);
            prop_assert_eq!(i64::from(told), behind.abs());
            let made = bench.axis.steps() - before;
            let asked = target - before;
            prop_assert!(made * asked >= 0 && made.abs() <= asked.abs().min(10), "{made} of {asked}");
        }
        for _ in 0..60 {
            bench.cycle(Coord::from_nm(target * 1000).unwrap());
        }
        prop_assert_eq!((bench.axis.steps(), bench.judge()), (target, target));
    }
}

/// A pin that fails at times.
struct Flaky {
    pin: Recorder,
    calls: u32,
}

impl ErrorType for Flaky {
    type Error = embedded_hal::digital::ErrorKind;
}

impl OutputPin for Flaky {
    fn set_low(&mut self) -> Result<(), Self::Error> {
        self.calls += 1;
        if self.calls.is_multiple_of(3) {
            return Err(embedded_hal::digital::ErrorKind::Other);
        }
        self.pin.set(false);
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Self::Error> {
        self.set_low()?;
        self.pin.set(true);
        Ok(())
    }
}

/// An edge that a pin does not take is tried again, and not counted before.
#[test]
fn a_pin_that_fails_loses_no_step() {
    let timing = StepTiming { ticks: 100, pulse: 1, pause: 1, setup: 1, hold: 1 };
    let (step, dir) = (Recorder::default(), Recorder::default());
    let flaky = |pin: &Recorder| Flaky { pin: pin.clone(), calls: 0 };
    let scale = Scale::new(1, 1000).unwrap();
    let pins = (flaky(&step), flaky(&dir));
    let mut axis = StepDir::new(pins.0, pins.1, scale, timing, Coord::ZERO, 10).unwrap();
    let mut failed = 0;
    for target in [7i64, -2, 5, 0, 0] {
        axis.begin(Coord::from_nm(target * 1000).unwrap());
        for _ in 0..100 {
            failed += u32::from(axis.tick().is_err());
        }
        assert_eq!(axis.steps(), target);
    }
    let rises = step.edges.borrow().iter().filter(|edge| edge.1).count();
    assert_eq!(rises, 7 + 9 + 7 + 5);
    assert!(failed > 10, "{failed}");
}

#[test]
fn an_axis_that_is_too_fast_is_refused() {
    let timing = StepTiming::from_ns(100_000, 1000, edges(2000, 5000));
    assert_eq!(timing, StepTiming { ticks: 100, pulse: 1, pause: 1, setup: 1, hold: 1 });
    assert_eq!(timing.most_steps(), 49);
    let make = |timing, most| {
        let pins = (Recorder::default(), Recorder::default());
        StepDir::new(pins.0, pins.1, Scale::new(1, 1000).unwrap(), timing, Coord::ZERO, most)
    };
    let error = make(timing, 50).err().unwrap();
    assert_eq!(error, StepError::TooFast { steps: 50, most: 49 });
    assert_eq!(error.to_string(), "50 steps per servo cycle at full speed; 49 fit into one");
    assert_eq!(make(StepTiming { setup: 0, ..timing }, 1).err(), Some(StepError::NoTime));
    // A timer that is slower than the servo cycle has no tick in it.
    let slow = StepTiming::from_ns(1000, 500, edges(1000, 1000));
    assert_eq!((slow.ticks, slow.most_steps()), (0, 0));
    assert_eq!(make(slow, 0).err(), Some(StepError::NoTime));
    let fast = StepTiming::from_ns(u32::MAX, u32::MAX, edges(u32::MAX, u32::MAX));
    assert_eq!((fast.ticks, fast.pulse, fast.most_steps()), (u32::MAX, u32::MAX, 0));
    assert!(Scale::new(0, 1).is_err() && Scale::new(1, 0).is_err());
}

/// Three axes of step and direction as a drive.
struct Steppers([Bench; 3]);

impl Drive<f32, 3> for Steppers {
    type Error = u32;
    fn drive(&mut self, setpoint: &Setpoint<f32, 3>) -> Result<(), u32> {
        for (axis, bench) in self.0.iter_mut().enumerate() {
            let left = bench.cycle(setpoint.position(axis));
            if left > 0 {
                return Err(left);
            }
            let wanted = Scale::new(400, 1_000_000).unwrap().steps(setpoint.position(axis));
            assert_eq!(bench.axis.steps(), wanted);
        }
        Ok(())
    }
}

/// The core's own motion at its limits: no step is ever late.
#[test]
fn a_path_at_full_speed_loses_no_step() {
    let axis = AxisLimits::linear(100.0, 2000.0, 50_000.0);
    let config = Config::new(Limits::new([axis; 3]).unwrap());
    let mut link = Box::new(Link::<f32, 3, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 3]).unwrap();
    // 100 kHz; 100 mm/s are 40 steps per cycle.
    let timing = StepTiming::from_ns(100_000, 1000, edges(1000, 5000));
    let scale = Scale::new(400, 1_000_000).unwrap();
    let mut drive = Steppers([(); 3].map(|()| Bench::new(scale, timing, Coord::ZERO, 41)));
    let point = |x, y, z| [x, y, z].map(|mm: i64| Coord::from_nm(mm * 1_000_000).unwrap());
    for (to, tag) in
        [point(30, 10, 0), point(0, 20, 5), point(30, 30, -5), point(0, 0, 0)].into_iter().zip(1..)
    {
        planner.push(&Block::rapid(to, tag)).unwrap();
    }
    planner.finish();
    loop {
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        drive.drive(&setpoint).unwrap();
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            break;
        }
    }
    for bench in &drive.0 {
        assert_eq!(bench.judge(), 0);
        assert!(bench.step.edges.borrow().len() > 2 * 400 * 10);
    }
}

#[test]
fn velocities_and_powers_become_duty_cycles() {
    let pin = Mock::new(&[
        Transaction::max_duty_cycle(1000),
        Transaction::set_duty_cycle(500),
        Transaction::max_duty_cycle(1000),
        Transaction::set_duty_cycle(750),
        Transaction::max_duty_cycle(1000),
        Transaction::set_duty_cycle(0),
        Transaction::max_duty_cycle(1000),
        Transaction::set_duty_cycle(500),
    ]);
    let mut drive = Analogue::bipolar(pin, 200.0f32);
    for velocity in [0.0, 100.0, -1000.0, f32::NAN] {
        drive.set(velocity).unwrap();
    }
    drive.release().done();
    let pin = Mock::new(&[
        Transaction::max_duty_cycle(u16::MAX),
        Transaction::set_duty_cycle(u16::MAX),
        Transaction::max_duty_cycle(u16::MAX),
        Transaction::set_duty_cycle(0),
    ]);
    let mut laser = Analogue::unipolar(pin, 100.0f64);
    laser.set(f64::INFINITY).unwrap();
    laser.set(-5.0).unwrap();
    laser.release().done();
    // Without a full scale there is nothing to say but 0.
    let pin = Mock::new(&[Transaction::max_duty_cycle(1000), Transaction::set_duty_cycle(500)]);
    let mut none = Analogue::bipolar(pin, 0.0f32);
    none.set(100.0).unwrap();
    none.release().done();
    let position = PositionLoop { gain: 20.0f32, most_error: 0.5 };
    assert_eq!(position.velocity(10.0, 0.25), Ok(15.0));
    let error = position.velocity(10.0, -0.75).unwrap_err();
    assert_eq!(error.to_string(), "following error is -0.75 mm; 0.5 is allowed");
    assert!(
        position.velocity(10.0, f32::NAN).is_err() && position.velocity(f32::NAN, 0.0).is_err()
    );
}
