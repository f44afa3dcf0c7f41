//! A curve by its control points, line by line (G5.2 to G5.3), as LinuxCNC has it.
//!
//! `G5.2 P L` begins where the machine stands: that is the first control point, P its weight, L the order (degree + 1). Every line
//! behind it is a further one, X and Y and its weight P. G5.3 ends the block, and the curve is run to its last control point; its
//! knots are 0, 1, 2 and so on, the outer ones as often as the order says.
//!
//! Nothing moves before G5.3: a block with a line that is refused is refused as a whole.

use super::error::{Reason, Refusal};
use super::groups::{Codes, Found, Group};
use super::modal::{Mode, Plane};
use super::offsets::Place;
use super::reader::Reader;
use super::words::Words;
use super::{AXES, Code};
use crate::block::{Block, Feed, Motion};
use crate::machine::Quantity;
use crate::spline::nurbs::{Cubic, Cubics, DEGREE, ERROR, Knots, Nurbs};
use heapless::Vec;

/// Whether curves are read: without the feature `nurbs` their code and room are left out.
const IS_READ: bool = cfg!(feature = "nurbs");
/// Most control points of a curve; 0 without the feature `nurbs`.
pub const POINTS: usize = if IS_READ { 64 } else { 0 };
/// Least order: LinuxCNC takes lesser ones for this.
const LEAST_ORDER: usize = 3;
/// Weights that are taken.
const WEIGHTS: (f64, f64) = (1.0e-3, 1.0e3);

/// Its first code.
pub const BEGIN: Code = Code::g(52);
/// Its last one.
pub const END: Code = Code::g(53);

/// A curve, as it is read and then given out; kept where it is, for it is large.
#[derive(Debug, Default)]
pub struct Curve {
    /// From the first control point, mm.
    points: Vec<[f64; 2], POINTS>,
    weights: Vec<f64, POINTS>,
    order: usize,
    /// Where it begins and ends.
    from: Place,
    to: Place,
    stage: Stage,
}

#[derive(Clone, Copy, Debug, Default)]
enum Stage {
    /// There is none.
    #[default]
    None,
    /// Between G5.2 and G5.3; whether a line of it has been refused.
    Open { refused: bool },
    /// Behind G5.3: what of it is to be given out.
    Done(Rest),
}

/// What of a curve is to be given out.
#[derive(Clone, Copy, Debug)]
struct Rest {
    /// The next cubic: it is one ahead, so that the last one is known.
    next: Cubic<2>,
    cubics: Cubics,
    feed: Feed<f64>,
    tolerance: Option<f64>,
    exact_stop: bool,
    line: u32,
}

impl Curve {
    /// Whether there is none, or it has been given out.
    pub fn is_done(&self) -> bool {
        !(IS_READ && matches!(self.stage, Stage::Done(_)))
    }

    /// Whether G5.3 is to come.
    pub fn is_open(&self) -> bool {
        IS_READ && matches!(self.stage, Stage::Open { .. })
    }

    /// A line has been refused. If it is that of G5.3 there is no curve any more; then it says where it would have ended.
    pub fn refuse(&mut self) -> Option<Place> {
        match &mut self.stage {
            Stage::Open { refused } => *refused = true,
            Stage::Done(_) => {
                self.stage = Stage::None;
                return Some(self.to);
            }
            Stage::None => {}
        }
        None
    }

    /// The line of G5.3 has been refused as a whole: there is none any more. Says where it would have ended.
    pub fn refuse_end(&mut self) -> Place {
        self.stage = Stage::None;
        self.to
    }

    /// There is none any more.
    pub fn drop(&mut self) {
        self.stage = Stage::None;
    }

    /// A block begins, where the machine stands.
    pub fn begin(&mut self, from: &Place) {
        self.points.clear();
        self.weights.clear();
        self.order = LEAST_ORDER;
        (self.from, self.to) = (*from, *from);
        self.stage = Stage::Open { refused: false };
    }

    fn push(&mut self, to: &Place, weight: f64) -> Result<(), Reason> {
        let point = core::array::from_fn(|axis| match (to.get(axis), self.from.get(axis)) {
            (Some(to), Some(from)) => to.minus(*from),
            _ => 0.0,
        });
        let full = Reason::ControlPoints {
            found: POINTS as u32 + 1,
            least: self.order as u32,
            greatest: POINTS as u32,
        };
        self.points.push(point).map_err(|_| full)?;
        self.weights.push(weight).map_err(|_| full)?;
        self.to = *to;
        Ok(())
    }

    /// The next block: the cost is that of a few parts of the curve. The machine stands at `position` before and after it.
    pub fn step(&mut self, position: &mut Place) -> Option<Block<f64, AXES>> {
        if self.is_done() {
            return None;
        }
        let Stage::Done(mut rest) = self.stage else { return None };
        let Cubic { points: [_, first, second, end], is_straight, .. } = rest.next;
        let following =
            Nurbs::new(self.order.saturating_sub(1), &self.points, &self.weights, Knots::Even)
                .ok()
                .and_then(|curve| rest.cubics.step(&curve, ERROR));
        let is_last = following.is_none();
        let place = |[x, y]: [f64; 2]| {
            let mut place = self.from;
            for (slot, mm) in place.iter_mut().zip([x, y]) {
                *slot = slot.plus(mm);
            }
            place
        };
        let to = if is_last { self.to } else { place(end) };
        let motion = if is_straight {
            Motion::Line { to }
        } else {
            Motion::Cubic { controls: [place(first), place(second)], to }
        };
        *position = to;
        let Rest { feed, tolerance, line, .. } = rest;
        // It stops at the end of the curve, and not wherever that was cut.
        let exact_stop = rest.exact_stop && is_last;
        self.stage = match following {
            Some(next) => {
                rest.next = next;
                Stage::Done(rest)
            }
            None => Stage::None,
        };
        Some(Block { motion, feed, tolerance, exact_stop, tag: line })
    }
}

/// What the tolerance of a curve leaves to the motion along the cubics that stand for it.
fn left_of(tolerance: f64) -> f64 {
    let left = tolerance - ERROR;
    if left >= Quantity::CurveTolerance.range().least { left } else { tolerance }
}

impl Reader {
    /// G5.2: the block begins, with the weight of the first control point, or with a further one.
    pub(super) fn begin_curve(
        &mut self,
        (code, column): Found,
        codes: &Codes,
        words: &mut Words,
    ) -> Result<(), Refusal> {
        let refuse = |column, what| Err(Refusal::new(column, Reason::Context { code, what }));
        if code == END {
            return refuse(column, "ends a NURBS block, and none has begun (G5.2)");
        }
        (self.curve, self.series) = (None, None);
        self.nurbs.begin(&self.position);
        if self.modal.plane != Plane::Xy {
            return refuse(column, "needs the XY plane (G17)");
        }
        if self.modal.relative {
            return refuse(
                column,
                "needs absolute coordinates (G90): under G91 they are read in two ways",
            );
        }
        if self.modal.inverse_time {
            return refuse(column, "needs a feed per minute (G94)");
        }
        if let Some((other, place)) = codes.last().or(codes.g(Group::Machine)) {
            let what = "cannot stand in the line in which a NURBS block begins";
            return Err(Refusal::new(place, Reason::Context { code: other, what }));
        }
        let order = words.take_in('L', code, (LEAST_ORDER as f64, DEGREE as f64 + 1.0), true)?;
        self.nurbs.order = order.map_or(LEAST_ORDER, |order| order as usize);
        let weight = words.take_in('P', code, WEIGHTS, false)?;
        let alone = !(words.has('X') || words.has('Y'));
        let first = if alone { weight } else { None };
        let from = self.position;
        self.nurbs
            .push(&from, first.unwrap_or(1.0))
            .map_err(|reason| Refusal::new(column, reason))?;
        if alone {
            return Ok(());
        }
        self.control_point((code, column), weight, words)
    }

    /// A line of an open block.
    pub(super) fn curve_line(&mut self, codes: &Codes, words: &mut Words) -> Result<(), Refusal> {
        if let Some((code, column)) = codes.other_than([BEGIN, END]) {
            let what = "cannot stand in a NURBS block (G5.2 to G5.3)";
            return Err(Refusal::new(column, Reason::Context { code, what }));
        }
        self.feed_word(words)?;
        match codes.g(Group::Motion) {
            Some(found @ (END, _)) => self.end_curve(found, words),
            found => {
                let has = ['X', 'Y', 'P'].into_iter().any(|letter| words.has(letter));
                if !has {
                    return Ok(());
                }
                let found = found.unwrap_or((BEGIN, words.axis_column()));
                let weight = words.take_in('P', BEGIN, WEIGHTS, false)?;
                self.control_point(found, weight, words)
            }
        }
    }

    fn control_point(
        &mut self,
        (code, column): Found,
        weight: Option<f64>,
        words: &mut Words,
    ) -> Result<(), Refusal> {
        let mut values = [None; AXES];
        for (slot, letter) in values.iter_mut().zip(['X', 'Y']) {
            *slot = words.take(letter, code)?;
        }
        let [Some(_), Some(_), ..] = values else {
            let what = "X and Y together";
            return Err(Refusal::new(column, Reason::Missing { code, what }));
        };
        let to = self.target(&values, false).map_err(|reason| words.blame(reason))?;
        self.nurbs.push(&to, weight.unwrap_or(1.0)).map_err(|reason| Refusal::new(column, reason))
    }

    /// G5.3: the curve is run, unless a line of it has been refused.
    fn end_curve(&mut self, (code, column): Found, words: &mut Words) -> Result<(), Refusal> {
        let Stage::Open { refused } = self.nurbs.stage else { return Ok(()) };
        self.nurbs.drop();
        self.modal.mode = Mode::None;
        let (found, least) = (self.nurbs.points.len(), self.nurbs.order);
        let reason = if refused {
            let what = "ends a NURBS block of which a line has been refused";
            Some(Reason::Context { code, what })
        } else if found < least {
            let [found, least, greatest] = [found, least, POINTS].map(|count| count as u32);
            Some(Reason::ControlPoints { found, least, greatest })
        } else {
            None
        };
        if let Some(reason) = reason {
            // The lines behind it are read as if it had been run.
            self.position = self.nurbs.to;
            return Err(Refusal::new(column, reason));
        }
        let feed = self.speed((code, column), true, words)?;
        let order = self.nurbs.order;
        let (points, weights) = (&self.nurbs.points, &self.nurbs.weights);
        // Whatever could be wrong with it has been refused by its lines.
        let Ok(curve) = Nurbs::new(order.saturating_sub(1), points, weights, Knots::Even) else {
            return Err(Refusal::new(column, Reason::Unknown(code)));
        };
        let mut cubics = Cubics::default();
        let Some(next) = cubics.step(&curve, ERROR) else { return Ok(()) };
        self.set_named_axis(0);
        self.set_named_axis(1);
        self.nurbs.stage = Stage::Done(Rest {
            next,
            cubics,
            feed,
            tolerance: self.modal.tolerance.map(left_of),
            exact_stop: self.modal.exact_stop,
            line: self.line,
        });
        Ok(())
    }
}
