//! Paths of every kind, and motions of every kind over their cells, against the velocity of every axis, the band and
//! the ends of the cells.

use super::bounds::{Bounds, Pace};
use super::compile::{Placement, piece};
use super::law::{Law, PathState};
use super::rows::View;
use crate::block::{Block, FINEST_BAND, Feed, Motion, Turn};
use crate::machine::{AxisLimits, Config, LimitSets, Limits};
use crate::number::serial::NodeSerial;
use crate::number::{ArcLength, Coord, Interval, Length, Scalar};
use crate::path::builder::Builder;
use crate::path::cut::{Cut, Emitted};
use crate::path::node::{Node, Programmed};
use crate::path::segment::Segment;
use crate::servo::piece::Sequel;
use core::array::from_fn;

const AXES: usize = 3;

/// Xorshift: the same draws everywhere.
struct Draws(u64);

impl Draws {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// All orders of magnitude between two powers of ten alike.
    fn power(&mut self, from: f64, to: f64) -> f64 {
        10f64.powf(from + (to - from) * self.unit())
    }

    /// A machine of very unequal axes.
    fn config<S: Scalar>(&mut self) -> Config<S, AXES> {
        let axes = from_fn(|_| AxisLimits {
            velocity: S::of(self.power(-0.5, 3.0)),
            acceleration: S::of(self.power(1.0, 4.0)),
            jerk: S::of(self.power(3.0, 6.0)),
            rotary: false,
        });
        let mut config = Config::new(Limits::new(axes).unwrap());
        config.tolerance = S::of(self.power(-3.5, 0.3));
        config
    }
}

/// A helix or a line that goes on in about the direction of the one before.
fn next<S: Scalar>(
    draws: &mut Draws,
    helix: bool,
    (here, tangent): (&[Coord; AXES], &[f64; AXES]),
    radius: f64,
) -> Option<(Motion<S, AXES>, Segment<f64, AXES>)> {
    let kink = [0.0, 0.0, 0.01, 0.2, 1.0][(draws.unit() * 5.0) as usize];
    let direction: [f64; AXES] = from_fn(|i| tangent[i] + kink * (2.0 * draws.unit() - 1.0));
    if !helix {
        let length = draws.power(-1.5, 1.5);
        let to = from_fn(|i| here[i].plus(direction[i] * length));
        return Some((Motion::Line { to }, Segment::line(*here, to)?));
    }
    let flat = direction[0].hypot(direction[1]).max(1e-3);
    let (x, y) = (-direction[1] / flat * radius, direction[0] / flat * radius);
    let angle = 0.02 + 4.0 * draws.unit();
    let (sin, cos) = angle.sin_cos();
    let centre = (here[0].plus(x), here[1].plus(y));
    let to = [
        centre.0.plus(y * sin - x * cos),
        centre.1.plus(-x * sin - y * cos),
        here[2].plus(direction[2] / flat * radius * angle),
    ];
    let (plane, turn) = ((0, 1), Turn::CounterClockwise);
    let segment = Segment::arc(*here, to, plane, centre, turn, 0).ok()?;
    Some((Motion::Arc { to, plane, centre, turn, extra_turns: 0 }, segment))
}

/// Hands the curved cells of some moves, one after the other, to `see`.
fn cells<S: Scalar>(
    draws: &mut Draws,
    config: &Config<S, AXES>,
    mut see: impl FnMut(&mut Draws, &Emitted<S, AXES>),
) {
    let (mut here, mut tangent) = ([Coord::ZERO; AXES], [1.0, 0.0, 0.0]);
    let start = Node { at: here, tangent: tangent.map(S::of), curvature: [S::ZERO; AXES] };
    let mut builder = Builder::<S, AXES, 16>::EMPTY;
    builder.restart(here);
    let radius = draws.power(-1.5, 2.0);
    let first = draws.unit() < 0.5;
    for n in 0..5 {
        let helix = (n % 2 == 0) == first;
        let Some((motion, segment)) = next(draws, helix, (&here, &tangent), radius) else {
            continue;
        };
        let feed = Feed::PerSecond(S::of(1e5));
        let block = Block { motion, feed, tolerance: None, exact_stop: false, tag: 1 };
        if builder.push(&block, config).is_ok() {
            (here, tangent) = (segment.end, segment.end_frame().tangent);
        }
    }
    builder.close();
    let mut last = start;
    for _ in 0..4000 {
        let cut = match builder.emit(&last, config) {
            Cut::Cell(cut) => cut,
            Cut::Working => continue,
            Cut::Nothing => return,
        };
        if !cut.cell.straight {
            see(draws, &cut);
        }
        last = cut.node;
    }
}

/// The motion over a length whose speed has these Bernstein coefficients, if there is one.
fn law<S: Scalar>(length: S, [p0, p1, p2, p3]: [S; 4]) -> Option<Law<S>> {
    let time = S::of(4.0) * length / (p0 + p1 + p2 + p3);
    let three = S::of(3.0) / time;
    let [start, end] =
        [(p0, p1 - p0), (p3, p3 - p2)].map(|(v, gain)| PathState { b: v * v, a: gain * three });
    Law::new(length, start, end)
}

/// The greatest velocity of any axis over its limit in such a motion.
fn over<S: Scalar>(view: &View<'_, S, AXES>, speeds: [S; 4]) -> f64 {
    let Some(law) = law(view.cell.length, speeds) else { return 0.0 };
    let place =
        Placement { serial: NodeSerial::ZERO, arc_length: ArcLength::ZERO, sequel: Sequel::Motion };
    let piece = piece(view, &law, place);
    let mut worst = 0.0f64;
    for (axis, c) in view.limits.axes().iter().zip(&piece.axes) {
        let c = c.map(Scalar::to_f64);
        for k in 0..=16 {
            let t = law.time.to_f64() * f64::from(k) / 16.0;
            let inner = 3.0 * c[2] + t * (4.0 * c[3] + t * 5.0 * c[4]);
            let velocity = c[0] + t * (2.0 * c[1] + t * inner);
            worst = worst.max(velocity.abs() / axis.velocity.to_f64());
        }
    }
    worst
}

fn search<S: Scalar>(rounds: u32) {
    let mut draws = Draws(0x9E37_79B9_7F4A_7C15);
    for round in 0..rounds {
        let config = draws.config::<S>();
        let limits = config.limits;
        cells(&mut draws, &config, |draws, cut| {
            let (one, cycle) = (S::ONE, S::of(1e-9));
            let pace = Pace { limits: LimitSets::only(&limits), cycle, feed: one, rapid: one };
            let (from, cell, to) = (&cut.from, &cut.cell, &cut.node);
            let bounds = Bounds::new(from, cell, to, &pace);
            let limits = &limits;
            let view = View {
                from,
                cell,
                to,
                bounds,
                limits,
                leaves: false,
                share: one,
                penalty: S::ZERO,
                led: true,
            };
            // Steadily, and in any other way, half of it at the bound.
            for n in 0..4 {
                let speeds = from_fn(|_| {
                    let least = if n == 0 || draws.unit() < 0.5 { 1.0 } else { draws.unit() };
                    bounds.speed * S::of(least)
                });
                let over = over(&view, speeds);
                assert!(over <= 1.0, "round {round}: {over} at speeds {speeds:?} on {cell:?}");
            }
        });
    }
}

/// Helices and lines that blend into each other, pass or turn, on machines whose axes differ by three orders of
/// magnitude: an axis that hardly moves may be what binds, and turns round within a cell.
#[test]
fn no_axis_exceeds_its_velocity_within_a_cell() {
    search::<f64>(3000);
    search::<f32>(1000);
}

/// A cell ends at its node: what its polynomials miss it by is a jump of the position.
fn ends<S: Scalar>(rounds: u32, floor: f64) {
    let mut draws = Draws(0x2545_F491_4F6C_DD1D);
    for round in 0..rounds {
        let config = draws.config::<S>();
        cells(&mut draws, &config, |_, cut| {
            let length = cut.cell.length.to_f64();
            for i in 0..AXES {
                let direction =
                    cut.from.tangent[i].to_f64() * length + cut.cell.tangent_offset[i].to_f64();
                let missed = direction - cut.node.at[i].minus::<f64>(cut.from.at[i]);
                let most = 4.0 * S::EPSILON.to_f64() * length + floor;
                assert!(missed.abs() <= most, "round {round}: {missed} of {length} on axis {i}");
            }
        });
    }
}

#[test]
fn cells_end_where_the_next_begin() {
    ends::<f64>(300, 4e-12);
    // Where a line follows a run, its start is rounded.
    ends::<f32>(1000, 1e-8);
}

/// Any motion over the longest cell of an arc: steady, braking hard, creeping at either end.
#[test]
fn no_motion_over_a_cell_of_an_arc_leaves_the_band() {
    let mut draws = Draws(0xD1B5_4A32_D192_ED03);
    let one = AxisLimits::linear(1.0, 1.0, 1.0);
    let limits = Limits::new([one; AXES]).unwrap();
    let mut worst = 0.0f64;
    for _ in 0..300 {
        let radius = draws.power(-1.0, 3.0);
        let band = radius * draws.power(-6.0, -2.0);
        let mm = |x: f64| Coord::from_mm(x).unwrap();
        let ends = ([mm(radius), mm(0.0), mm(0.0)], [mm(0.0), mm(radius), mm(0.0)]);
        let centre = (mm(0.0), mm(0.0));
        let arc =
            Segment::<f64, AXES>::arc(ends.0, ends.1, (0, 1), centre, Turn::CounterClockwise, 0);
        let arc = arc.unwrap();
        let length = arc.longest_cell(band);
        let end = Length::from_mm(length);
        let programmed = Programmed::feed(1.0);
        let (from, cell, to) = (
            arc.node(Length::ZERO),
            arc.cell(Interval { from: Length::ZERO, to: end }, programmed),
            arc.node(end),
        );
        let view = View::unbound([&from, &to], &cell, &limits);
        for _ in 0..300 {
            let speeds =
                from_fn(|_| if draws.unit() < 0.4 { 1e-4 * draws.unit() } else { draws.unit() });
            let Some(law) = law(length, speeds) else { continue };
            let place = Placement {
                serial: NodeSerial::ZERO,
                arc_length: ArcLength::ZERO,
                sequel: Sequel::Motion,
            };
            let piece = piece(&view, &law, place);
            for k in 1..32 {
                let at = piece.at(law.time * f64::from(k) / 32.0);
                let off = (at.position_mm(0).hypot(at.position_mm(1)) - radius).abs();
                worst = worst.max(off / band.max(FINEST_BAND));
            }
        }
    }
    // The worst of them make use of it.
    assert!((0.8..=1.0).contains(&worst), "{worst}");
}
