//! Machines of the soak, and how their cores are set up.

use super::draw::log;
use crate::moves::between;
use fastrand::Rng;
use splineway::machine::Quantity;
use splineway::number::Range;
use splineway::{AxisLimits, Config, ConfigError, CornerMode, Limits, Scalar};
use splineway_simulator::machine::Axis;
use splineway_simulator::program::{AXES, Point};

/// The cores that are soaked: scalar, axes, blocks, nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // Names say it.
pub enum Core {
    F64x1x4x48,
    F64x2x16x64,
    F64x3x8x56,
    F64x3x64x192,
    F64x6x16x64,
    F64x9x16x64,
    F32x1x16x64,
    F32x2x8x48,
    F32x3x16x64,
    F32x4x128x96,
    F32x9x8x56,
}

/// All of them, with their numbers of axes.
pub const CORES: [(Core, usize); 11] = [
    (Core::F64x1x4x48, 1),
    (Core::F64x2x16x64, 2),
    (Core::F64x3x8x56, 3),
    (Core::F64x3x64x192, 3),
    (Core::F64x6x16x64, 6),
    (Core::F64x9x16x64, 9),
    (Core::F32x1x16x64, 1),
    (Core::F32x2x8x48, 2),
    (Core::F32x3x16x64, 3),
    (Core::F32x4x128x96, 4),
    (Core::F32x9x8x56, 9),
];

/// The machine of a case and how its core is set up.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Which core.
    pub core: Core,
    /// Limits of its axes.
    pub axes: Vec<Axis>,
    /// Axes that turn: from this one on.
    pub rotary_from: usize,
    /// s.
    pub cycle: f64,
    /// mm.
    pub tolerance: f64,
    /// s.
    pub lead: f64,
    /// s.
    pub start_delay: f64,
    /// Overlap factor of the paper's corners, if they are used.
    pub lambda: Option<f64>,
    /// Improvement steps.
    pub iterations: u16,
    /// Smoothing sweeps.
    pub sweeps: u16,
    /// Where the machine stands at first.
    pub start: Point,
}

impl Setting {
    /// Whether the core computes in `f64`.
    pub fn is_double(&self) -> bool {
        CORES.iter().position(|(core, _)| *core == self.core) < Some(6)
    }

    /// Nodes of the core's window.
    pub fn nodes(&self) -> usize {
        match self.core {
            Core::F64x1x4x48 | Core::F32x2x8x48 => 48,
            Core::F64x3x8x56 | Core::F32x9x8x56 => 56,
            Core::F32x4x128x96 => 96,
            Core::F64x3x64x192 => 192,
            _ => 64,
        }
    }

    /// For the core.
    ///
    /// # Errors
    /// What it does not accept.
    pub fn config<S: Scalar, const N: usize>(&self) -> Result<Config<S, N>, ConfigError> {
        let limits = std::array::from_fn(|n| AxisLimits {
            velocity: S::of(self.axes[n].velocity),
            acceleration: S::of(self.axes[n].acceleration),
            jerk: S::of(self.axes[n].jerk),
            rotary: n >= self.rotary_from,
        });
        let mut config = Config::new(Limits::new(limits)?);
        config.cycle = S::of(self.cycle);
        config.tolerance = S::of(self.tolerance);
        config.lead = S::of(self.lead);
        config.start_delay = S::of(self.start_delay);
        config.iterations = self.iterations;
        config.sweeps = self.sweeps;
        if let Some(lambda) = self.lambda {
            config.corner = CornerMode::Paper { lambda: S::of(lambda) };
        }
        config.check()?;
        Ok(config)
    }

    pub(super) fn any(rng: &mut Rng) -> Self {
        let (core, count) = CORES[rng.usize(..CORES.len())];
        let usual = Axis { velocity: 200.0, acceleration: 2000.0, jerk: 50_000.0 };
        let base = if rng.u8(..3) == 0 {
            usual
        } else {
            let velocity = log(rng, 0.5, 3.3);
            let acceleration = velocity / log(rng, -2.0, 0.0);
            Axis { velocity, acceleration, jerk: acceleration / log(rng, -2.5, -0.7) }
        };
        let unequal = rng.u8(..4);
        let axes = (0..count)
            .map(|n| {
                let share = match unequal {
                    0 => 1.0 - 0.08 * n as f64,
                    1 => log(rng, -1.0, 0.0),
                    _ => 1.0,
                };
                let Axis { velocity, acceleration, jerk } = base;
                Axis {
                    velocity: velocity * share,
                    acceleration: acceleration * share,
                    jerk: jerk * share,
                }
            })
            .collect();
        // Where nothing is said, what is usual; often enough anything that is accepted.
        let or = |rng: &mut Rng, usual: f64, any: fn(&mut Rng) -> f64| {
            if rng.bool() { usual } else { any(rng) }
        };
        let mut start = [0.0; AXES];
        if rng.u8(..4) == 0 {
            for slot in &mut start[..count] {
                *slot = (between(rng, -1.0, 1.0) * 2.0e6).round() * 1.0e-3;
            }
        }
        Self {
            core,
            axes,
            rotary_from: if rng.bool() { 3 } else { AXES },
            cycle: or(rng, 1.0e-3, |rng| log(rng, -4.7, -2.0)),
            tolerance: or(
                rng,
                0.01,
                |rng| if rng.u8(..6) == 0 { 0.0 } else { log(rng, -3.5, 0.0) },
            ),
            lead: or(rng, 0.01, |rng| if rng.u8(..4) == 0 { 0.0 } else { log(rng, -3.0, -0.3) }),
            start_delay: or(rng, 0.05, |rng| if rng.bool() { 0.0 } else { log(rng, -3.0, -0.5) }),
            lambda: (rng.u8(..7) == 0).then(|| [0.0, 0.99, rng.f64() * 0.99][rng.usize(..3)]),
            iterations: within(
                Quantity::Iterations,
                [40, 40, 40, 0, 15, 20, 100, 1000][rng.usize(..8)],
            ),
            sweeps: within(Quantity::Sweeps, [8, 8, 8, 8, 0, 1, 2, 32, 1000][rng.usize(..9)]),
            start,
        }
    }
}

/// The nearest number that is accepted for a setting.
fn within(quantity: Quantity, value: u16) -> u16 {
    let Range { least, greatest } = quantity.range();
    f64::from(value).clamp(least, greatest) as u16
}
