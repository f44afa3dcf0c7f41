//! Arcs (G2, G3) and curves (G5, G5.1).

use super::AXES;
use super::dialect::Dialect;
use super::error::{Reason, Refusal};
use super::groups::Found;
use super::modal::{Mode, Plane};
use super::offsets::{Place, sum};
use super::reader::Reader;
use super::words::Words;
use crate::block::{Motion, Turn, centre_from_radius};
use crate::number::Coord;

/// Most turns of an arc.
const TURNS: f64 = 1000.0;

impl Reader {
    /// An arc to `to`: by its centre, or by its radius.
    pub(super) fn arc(
        &self,
        found: Found,
        from: &Place,
        to: Place,
        words: &mut Words,
    ) -> Result<Motion<f64, AXES>, Refusal> {
        let (code, column) = found;
        let plane @ (p, q) = self.modal.plane.axes();
        let letters = self.modal.plane.centre_letters();
        let turn = if self.modal.mode == Mode::Clockwise {
            Turn::Clockwise
        } else {
            Turn::CounterClockwise
        };
        let centre = (words.take(letters.0, code)?, words.take(letters.1, code)?);
        let radius = words.take('R', code)?;
        let in_plane = |place: &Place| {
            let at = |axis: usize| place.get(axis).copied().unwrap_or_default();
            (at(p), at(q))
        };
        let refuse = |column, reason| Err(Refusal::new(column, reason));
        let centre = match (radius, centre) {
            (Some(radius), (None, None)) => {
                let radius = radius * self.scale();
                match centre_from_radius(in_plane(from), in_plane(&to), radius, turn) {
                    Ok(centre) => centre,
                    Err(error) => return refuse(words.column('R'), Reason::Arc(error)),
                }
            }
            (Some(_), _) => {
                let what = "takes a radius or a centre, not both";
                return refuse(words.column('R'), Reason::Context { code, what });
            }
            (None, (None, None)) => {
                let what = "a centre (two of I, J, K by the plane) or a radius (R)";
                return refuse(column, Reason::Missing { code, what });
            }
            (None, offsets) => self.centre(found, in_plane(from), offsets)?,
        };
        let limit = Coord::LIMIT_MM;
        for (axis, coord) in [(p, centre.0), (q, centre.1)] {
            if coord.to_mm().abs() > limit {
                return refuse(column, Reason::Centre { axis });
            }
        }
        // Of printers some do not know P, others run so many circles more: there it is nobody's word.
        let is_marlin = self.settings.dialect == Dialect::Marlin;
        let turns = if is_marlin { None } else { words.take_in('P', code, (1.0, TURNS), true)? };
        let turns = turns.unwrap_or(1.0);
        Ok(Motion::Arc { to, plane, centre, turn, extra_turns: turns as u16 - 1 })
    }

    /// The centre by its words: from the start, or of the program (G90.1).
    fn centre(
        &self,
        (code, column): Found,
        from: (Coord, Coord),
        offsets: (Option<f64>, Option<f64>),
    ) -> Result<(Coord, Coord), Refusal> {
        let refuse = |reason| Refusal::new(column, reason);
        let plane @ (p, q) = self.modal.plane.axes();
        let length =
            |axis, value| self.coordinate(axis, value).map_err(|_| refuse(Reason::Centre { axis }));
        if self.modal.absolute_centre {
            let (Some(x), Some(y)) = offsets else {
                let what = "both words of its centre under G90.1";
                return Err(refuse(Reason::Missing { code, what }));
            };
            return Ok(self.frame.in_machine((length(p, x)?, length(q, y)?), plane));
        }
        let offset = (length(p, offsets.0.unwrap_or(0.0))?, length(q, offsets.1.unwrap_or(0.0))?);
        if self.frame.rotation.is_none() {
            return Ok((sum(from.0, offset.0), sum(from.1, offset.1)));
        }
        let turned = self.frame.vector((offset.0.to_mm(), offset.1.to_mm()));
        Ok((from.0.plus(turned.0), from.1.plus(turned.1)))
    }

    /// Two words of a curve in the XY plane, mm of the program; `None` if neither is there.
    fn pair(
        &self,
        (code, column): Found,
        letters: [char; 2],
        words: &mut Words,
    ) -> Result<Option<[f64; 2]>, Refusal> {
        if self.modal.plane != Plane::Xy {
            let what = "needs the XY plane (G17)";
            return Err(Refusal::new(column, Reason::Context { code, what }));
        }
        let [x, y] = letters;
        match (words.take(x, code)?, words.take(y, code)?) {
            (None, None) => Ok(None),
            (Some(a), Some(b)) => {
                let mm = |letter, value: f64| {
                    let mm = value * self.scale();
                    let greatest = Coord::LIMIT_MM / self.scale();
                    let range =
                        Reason::Range { letter, value, least: -greatest, greatest, whole: false };
                    if mm.abs() <= Coord::LIMIT_MM {
                        Ok(mm)
                    } else {
                        Err(Refusal::new(words.column(letter), range))
                    }
                };
                Ok(Some([mm(x, a)?, mm(y, b)?]))
            }
            _ => {
                let what = if x == 'I' { "I and J together" } else { "P and Q together" };
                Err(Refusal::new(column, Reason::Missing { code, what }))
            }
        }
    }

    /// G5: I and J from the start to the first control point, P and Q from the end to the second. Without I and J
    /// the curve goes on from the G5 before.
    pub(super) fn cubic(
        &mut self,
        found: Found,
        from: &Place,
        to: Place,
        before: Option<[f64; 2]>,
        words: &mut Words,
    ) -> Result<Motion<f64, AXES>, Refusal> {
        let (code, column) = found;
        let missing = |what| Refusal::new(column, Reason::Missing { code, what });
        let first =
            self.pair(found, ['I', 'J'], words)?.or(before.map(|control| control.map(|x| -x)));
        let first = first.ok_or(missing("I and J where no G5 is before it"))?;
        let second = self.pair(found, ['P', 'Q'], words)?.ok_or(missing("P and Q"))?;
        self.curve = Some(second);
        Ok(self.thirds(from, to, [first, second]))
    }

    /// G5.1: I and J from the start to the only control point.
    pub(super) fn quadratic(
        &self,
        found: Found,
        from: &Place,
        to: Place,
        words: &mut Words,
    ) -> Result<Motion<f64, AXES>, Refusal> {
        let (code, column) = found;
        let missing = Refusal::new(column, Reason::Missing { code, what: "I and J" });
        let from_start = self.pair(found, ['I', 'J'], words)?.ok_or(missing)?;
        // From the end, in the program's coordinates.
        let plane = (0, 1);
        let (start, end) = (self.frame.in_program(from, plane), self.frame.in_program(&to, plane));
        let [x, y] = from_start;
        let from_end = [start.0.minus::<f64>(end.0) + x, start.1.minus::<f64>(end.1) + y];
        Ok(self.thirds(
            from,
            to,
            [from_start, from_end].map(|offset| offset.map(|x| x * 2.0 / 3.0)),
        ))
    }

    /// A curve by the offsets of its control points from its ends in the plane, mm of the program; the other axes move
    /// evenly.
    fn thirds(&self, from: &Place, to: Place, offsets: [[f64; 2]; 2]) -> Motion<f64, AXES> {
        let mut controls = [*from, to];
        let [first, second] = &mut controls;
        for (axis, (a, b)) in first.iter_mut().zip(second.iter_mut()).enumerate() {
            let third = b.minus::<f64>(*a) / 3.0;
            if axis >= 2 {
                (*a, *b) = (a.plus(third), b.plus(-third));
            }
        }
        for (point, [x, y]) in controls.iter_mut().zip(offsets) {
            let (x, y) = self.frame.vector((x, y));
            for (slot, mm) in point.iter_mut().zip([x, y]) {
                *slot = slot.plus(mm);
            }
        }
        Motion::Cubic { controls, to }
    }
}
