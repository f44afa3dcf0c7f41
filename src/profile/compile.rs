//! From planned states to pieces of motion.

use super::law::Law;
use super::rows::{Axis, View};
use crate::number::serial::NodeSerial;
use crate::number::{ArcLength, Scalar};
use crate::servo::piece::{Piece, Sequel};
use core::array::from_fn;

/// Where a piece stands in the path.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    pub serial: NodeSerial,
    pub arc_length: ArcLength,
    pub sequel: Sequel,
}

/// The piece over a cell: the very polynomials whose bounds the rows are.
pub fn piece<S: Scalar, const N: usize>(
    view: &View<'_, S, N>,
    law: &Law<S>,
    placement: Placement,
) -> Piece<S, N> {
    let rate = law.rate;
    let half = S::of(0.5);
    let straight = view.cell.straight;
    let axes = from_fn(|i| {
        let axis = Axis::new(view, law, i);
        let q: [S; 3] =
            if straight { from_fn(|j| axis.tangent * law.jerk[j]) } else { axis.jerks(law) };
        let e0 = if straight { S::ZERO } else { axis.e0 };
        // The jerk Q0 (1-u)^2 + 2 Q1 u (1-u) + Q2 u^2, integrated three times.
        [
            axis.tangent * law.v0,
            (axis.tangent * law.a0 + e0) * half,
            q[0] * S::of(1.0 / 6.0),
            (q[1] - q[0]) * rate * S::of(1.0 / 12.0),
            (q[0] - S::of(2.0) * q[1] + q[2]) * rate * rate * S::of(1.0 / 60.0),
        ]
    });
    let mut piece = Piece {
        serial: placement.serial,
        tag: view.cell.programmed.tag,
        time: law.time,
        origin: view.from.at,
        axes,
        arc_length: placement.arc_length,
        path: [
            law.v0,
            law.a0 * half,
            law.jerk[0] * S::of(1.0 / 6.0),
            (law.jerk[2] - law.jerk[0]) * rate * S::of(1.0 / 24.0),
        ],
        sequel: placement.sequel,
        event: false,
    };
    if !(law.v1 > S::ZERO) {
        piece.end_at(&view.to.at);
    }
    piece
}

/// Standing still for `time` seconds.
pub fn standstill<S: Scalar, const N: usize>(
    view: &View<'_, S, N>,
    placement: Placement,
) -> Piece<S, N> {
    Piece {
        serial: placement.serial,
        tag: view.cell.programmed.tag,
        time: view.cell.dwell,
        origin: view.from.at,
        axes: [[S::ZERO; 5]; N],
        arc_length: placement.arc_length,
        path: [S::ZERO; 4],
        sequel: placement.sequel,
        event: view.cell.event.is_some(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::Turn;
    use crate::machine::{AxisLimits, CornerMode, Limits};
    use crate::number::{Coord, Interval, Length};
    use crate::path::blend::{self, Blend};
    use crate::path::corner::Corner;
    use crate::path::half::Spot;
    use crate::path::joint::{BentLengths, mean_node, passes};
    use crate::path::node::Programmed;
    use crate::path::segment::Segment;
    use crate::path::swing;
    use crate::path::transition::Transition;
    use crate::profile::law::PathState;

    /// Places, mm, that a motion over a cell passes which stops at its end, starts at its beginning, or is steady.
    fn see_motions(view: &View<'_, f64, 2>, mut see: impl FnMut([f64; 2])) {
        // Constant jerk to or from rest: 2 v^2 = 3 |a| h.
        let push = 2.0 / 3.0 / view.cell.length;
        for (start, end) in [
            (PathState { b: 1.0, a: -push }, PathState::REST),
            (PathState::REST, PathState { b: 1.0, a: push }),
            (PathState { b: 1.0, a: 0.0 }, PathState { b: 1.0, a: 0.0 }),
        ] {
            let law = Law::new(view.cell.length, start, end).unwrap();
            let place = Placement {
                serial: NodeSerial::ZERO,
                arc_length: ArcLength::ZERO,
                sequel: Sequel::Motion,
            };
            let piece = piece(view, &law, place);
            for k in 0..=40 {
                let at = piece.at(law.time * f64::from(k) / 40.0);
                see([at.position_mm(0), at.position_mm(1)]);
            }
        }
    }

    /// A motion that comes to rest in a cell, or starts there, follows the cell's spline less closely
    /// than one that passes: in a corner it must stay inside the band all the same.
    #[test]
    fn a_rest_in_any_cell_of_a_corner_keeps_the_band() {
        let band = 0.05f64;
        let axis = AxisLimits::linear(1e3, 1e4, 1e6);
        let limits = Limits::new([axis; 2]).unwrap();
        for degrees in [2.0f64, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0, 105.0, 120.0, 135.0, 150.0] {
            let turn = degrees.to_radians();
            let (a, b) = ([1.0, 0.0], [turn.cos(), turn.sin()]);
            let corner = Corner::new(&a, &b);
            for room in [0.1, 0.3, 0.5, 0.8, 1.2, 2.0, 5.0, 20.0] {
                let half = swing::half(&corner, swing::CornerBand::around(band), room);
                let transition = Transition::new([Coord::ZERO; 2], (&a, &b), &corner, half);
                // Whole, or in two.
                let part = |node: u8, cut: f64| {
                    let cut = Spot { node, share: cut };
                    [(Spot::at(node), cut), (cut, Spot::at(node + 1))]
                };
                let parts = (0..transition.cells()).flat_map(|node| {
                    let whole = (Spot::at(node), Spot::at(node + 1));
                    [part(node, 0.1), part(node, 0.5), part(node, 0.9), [whole; 2]].concat()
                });
                for ends in parts {
                    let (from, to) = (transition.node(ends.0), transition.node(ends.1));
                    let programmed = Programmed::feed(1.0);
                    let cell = transition.cell(ends, &from, programmed);
                    let view = View::unbound([&from, &to], &cell, &limits);
                    see_motions(&view, |p| {
                        let off = |d: &[f64; 2], sign: f64| {
                            let along = (p[0] * d[0] + p[1] * d[1]) * sign;
                            let beside = (p[0] * d[1] - p[1] * d[0]).abs();
                            if along > 0.0 { p[0].hypot(p[1]) } else { beside }
                        };
                        let off = off(&a, 1.0).min(off(&b, -1.0));
                        assert!(off <= band * 0.999, "{degrees} {room} {ends:?}: {off}");
                    });
                }
            }
        }
    }

    /// The same in a blend from a line into an arc, at any turn between them.
    #[test]
    fn a_rest_in_any_cell_of_a_blend_keeps_the_band() {
        let band = 0.01f64;
        let axis = AxisLimits::linear(1e3, 1e4, 1e6);
        let limits = Limits::new([axis; 2]).unwrap();
        let mm = |p: [f64; 2]| p.map(|x| Coord::from_mm(x).unwrap());
        let joint = mm([0.0, 0.0]);
        let line = Segment::<f64, 2>::line(mm([-40.0, 0.0]), joint).unwrap();
        for (degrees, radius) in [0.0f64, 1.0, 5.0, 20.0, 45.0, 90.0, 130.0]
            .into_iter()
            .flat_map(|degrees| [0.5, 3.0, 10.0, 50.0].map(|radius| (degrees, radius)))
        {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let centre = [-radius * sin, radius * cos];
            // A quarter of a circle.
            let end = mm([centre[0] + radius * cos, centre[1] + radius * sin]);
            let (x, y) = (mm(centre)[0], mm(centre)[1]);
            let arc = Segment::arc(joint, end, (0, 1), (x, y), Turn::CounterClockwise, 0).unwrap();
            let most = 0.5 * line.length.min(arc.longest_angle() * 3.0);
            let reach = Blend::longest_reach(&line, &arc, band, most);
            assert!(reach > 0.0);
            let blend = Blend::new(&line, &arc, reach);
            // From the line before the joint, the arc behind it, or the joint.
            let off = |p: [f64; 2]| {
                let to_joint = p[0].hypot(p[1]);
                let beside_line = if p[0] < 0.0 { p[1].abs() } else { to_joint };
                let behind = p[0] * cos + p[1] * sin > 0.0;
                let gap = ((p[0] - centre[0]).hypot(p[1] - centre[1]) - radius).abs();
                beside_line.min(if behind { gap } else { to_joint })
            };
            for index in 0..blend::CELLS {
                let (from, to) = (blend.node(index), blend.node(index + 1));
                let programmed = Programmed::feed(1.0);
                let cell = blend.cell(index, &from, programmed);
                let view = View::unbound([&from, &to], &cell, &limits);
                see_motions(&view, |at| {
                    let off = off(at);
                    assert!(off <= band * 0.999, "{degrees} {radius} {index}: {off}");
                });
            }
        }
    }

    /// The same in the cells on either side of a joint that is simply passed: lines of any lengths, and a turn as great as
    /// the band allows.
    #[test]
    fn a_rest_beside_a_joint_that_is_passed_keeps_the_band() {
        let band = 0.01f64;
        let limits = Limits::new([AxisLimits::linear(1e3, 1e4, 1e6); 2]).unwrap();
        for (before, after) in [(10.0f64, 10.0f64), (10.0, 30.0), (30.0, 10.0), (3.0, 10.0)] {
            let mm = |p: [f64; 2]| p.map(|x| Coord::from_mm(x).unwrap());
            let joint = mm([0.0, 0.0]);
            let line = Segment::<f64, 2>::line(mm([-before, 0.0]), joint).unwrap();
            let frame_in = line.end_frame();
            let (next, out) = (0..100)
                .map(|k| 0.05 * 0.95f64.powi(k))
                .map(|turn| [turn.cos(), turn.sin()])
                .map(|out| (Segment::line(joint, mm(out.map(|x| x * after))).unwrap(), out))
                .find(|(next, _)| {
                    let frames = (&frame_in, &next.start_frame());
                    passes(&line, next, frames, band, CornerMode::Band)
                })
                .unwrap();
            let frame_out = next.start_frame();
            let lengths = BentLengths::new(line.length, next.length);
            let node = mean_node(joint, &frame_in, &frame_out, lengths);
            let programmed = Programmed::feed(1.0);
            for (segment, from, to, direction) in [
                (&line, line.node(Length::ZERO), node, [1.0, 0.0]),
                (&next, node, next.node(next.exact_length), out),
            ] {
                let whole = Interval { from: Length::ZERO, to: segment.exact_length };
                let mut cell = segment.cell(whole, programmed);
                for i in 0..2 {
                    cell.tangent_offset[i] += (direction[i] - from.tangent[i]) * cell.length;
                }
                cell.straight = false;
                let view = View::unbound([&from, &to], &cell, &limits);
                see_motions(&view, |at| {
                    let off = (at[0] * direction[1] - at[1] * direction[0]).abs();
                    // The other joint of the line may ask for as much.
                    assert!(off <= band * 0.5, "{before} {after}: {off}");
                });
            }
        }
    }
}
