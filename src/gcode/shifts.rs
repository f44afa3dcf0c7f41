//! Codes that say where the program's zero lies.

use super::dialect::Dialect;
use super::error::{Reason, Refusal};
use super::groups::{Codes, Found, Group};
use super::offsets::{OFFSETS, Rotation, Shift, Z, offset_code};
use super::reader::Reader;
use super::words::Words;
use super::{AXES, Code, is_rotary};
use crate::number::Coord;

const fn context(code: Code, column: u32, what: &'static str) -> Refusal {
    Refusal::new(column, Reason::Context { code, what })
}

impl Reader {
    /// A length of an axis as a coordinate: inches or mm; degrees of a rotary axis.
    pub(super) fn coordinate(&self, axis: usize, value: f64) -> Result<Coord, Reason> {
        let mm = if is_rotary(axis) { value } else { value * self.scale() };
        Coord::from_mm(mm).map_err(|error| Reason::Coordinate { axis, value: error.value })
    }

    fn fixed(&self, (code, column): Found) -> Result<(), Refusal> {
        if self.frame.rotation.is_some() {
            return Err(context(code, column, "cannot be used within a rotation (G68)"));
        }
        Ok(())
    }

    /// G54 to G59.3.
    pub(super) fn offset(&mut self, codes: &Codes) -> Result<(), Refusal> {
        let Some(found @ (code, column)) = codes.g(Group::Offset) else { return Ok(()) };
        let number = (0..OFFSETS).find(|&number| offset_code(number) == code).unwrap_or(OFFSETS);
        if number != self.frame.active() {
            self.fixed(found)?;
            // What a cycle has said was in the other coordinates.
            self.series = None;
        }
        if self.frame.select(number) {
            Ok(())
        } else {
            Err(Refusal::new(column, Reason::NoOffset(code)))
        }
    }

    /// G43, G43.1, G49: along Z.
    pub(super) fn length(&mut self, codes: &Codes, words: &mut Words) -> Result<(), Refusal> {
        let Some((code, column)) = codes.g(Group::Length) else { return Ok(()) };
        if self
            .frame
            .rotation
            .is_some_and(|rotation| rotation.plane.0 == Z || rotation.plane.1 == Z)
        {
            return Err(context(code, column, "cannot be used within a rotation (G68) of Z"));
        }
        self.series = None;
        let length = match code.tenths {
            490 => Coord::ZERO,
            431 => {
                codes.check_one_taker((code, column))?;
                let missing = Reason::Missing { code, what: "a Z word, the length of the tool" };
                let z = words.take('Z', code)?.ok_or(Refusal::new(column, missing))?;
                self.coordinate(Z, z).map_err(|reason| Refusal::new(words.column('Z'), reason))?
            }
            _ => {
                let h = words.take_in('H', code, (0.0, 99_999.0), true)?.map(|h| h as u32);
                let missing = Reason::Missing { code, what: "an H word, the number of a tool" };
                match h.or(self.loaded).ok_or(Refusal::new(column, missing))? {
                    0 if self.loaded.and_then(|tool| self.length_of(tool)).is_some() => {
                        let what = "with H0 is read in two ways: none, or the tool that is loaded";
                        return Err(context(code, words.column('H'), what));
                    }
                    0 => Coord::ZERO,
                    number => {
                        let unknown = Refusal::new(words.column('H'), Reason::NoTool(number));
                        self.length_of(number).ok_or(unknown)?
                    }
                }
            }
        };
        self.frame.set_tool(length);
        Ok(())
    }

    /// Length of a tool in the table.
    fn length_of(&self, number: u32) -> Option<Coord> {
        let mut tools = self.settings.setup.tools.iter().flatten();
        tools.find(|tool| tool.0 == number).map(|tool| tool.1)
    }

    /// G68 about a point (or where the tool is), G69.
    pub(super) fn rotation(&mut self, codes: &Codes, words: &mut Words) -> Result<(), Refusal> {
        let Some((code, column)) = codes.g(Group::Rotation) else { return Ok(()) };
        self.series = None;
        if code.tenths == 690 {
            self.frame.rotation = None;
            return Ok(());
        }
        codes.check_one_taker((code, column))?;
        if self.modal.relative {
            return Err(context(code, column, "under G91 is read in two ways: use G90"));
        }
        let plane @ (p, q) = self.modal.plane.axes();
        let missing = |what| Refusal::new(column, Reason::Missing { code, what });
        let angle = words.take_in('R', code, (-360.0, 360.0), false)?;
        let angle = angle.ok_or(missing("an R word, the angle in degrees"))?;
        let letter = |axis: usize| super::LETTERS.get(axis).copied().unwrap_or('X');
        let centre = match (words.take(letter(p), code)?, words.take(letter(q), code)?) {
            (None, None) => {
                // Where it is in a program that is not turned.
                self.frame.rotation = None;
                self.frame.in_program(&self.position, plane)
            }
            (Some(x), Some(y)) => {
                let at = |axis: usize, value: f64| {
                    let refuse = |reason| Refusal::new(words.column(letter(axis)), reason);
                    self.coordinate(axis, value).map_err(refuse)
                };
                (at(p, x)?, at(q, y)?)
            }
            _ => return Err(missing("both coordinates of its centre, or neither")),
        };
        self.frame.rotation = Some(Rotation::new(plane, centre, angle));
        Ok(())
    }

    /// G10, G52, G92 and theirs.
    pub(super) fn shift(
        &mut self,
        found: Found,
        codes: &Codes,
        words: &mut Words,
    ) -> Result<(), Refusal> {
        let (code, column) = found;
        self.fixed(found)?;
        self.series = None;
        match code.tenths {
            921 | 922 => self.frame.clear_shift(code.tenths == 922),
            923 => self.frame.restore_shift(),
            _ => {
                codes.check_one_taker(found)?;
                let other = if code.tenths == 520 { Shift::Preset } else { Shift::Local };
                if code.tenths != 100 && self.frame.shift_kind() == other {
                    let what =
                        "with the shift of G52 or G92 in force is read in two ways: end that first";
                    return Err(context(code, column, what));
                }
                self.set_shift(code, column, words)?;
            }
        }
        Ok(())
    }

    fn set_shift(&mut self, code: Code, column: u32, words: &mut Words) -> Result<(), Refusal> {
        let target = if code.tenths == 100 { Some(self.table(code, column, words)?) } else { None };
        let values = words.take_axes(code)?;
        let is_marlin = self.settings.dialect == Dialect::Marlin;
        if values == [None; AXES] {
            if is_marlin && code.tenths == 920 {
                // With an E word it is of the extruder only; alone it does nothing there, and sets all axes to 0 elsewhere.
                if !words.has('E') {
                    let what = "without axis words is read in two ways: name the axes";
                    return Err(context(code, column, what));
                }
                self.extruder(code, words);
                return Ok(());
            }
            return Err(Refusal::new(column, Reason::Missing { code, what: "an axis word" }));
        }
        for (axis, value) in values.into_iter().enumerate() {
            let Some(value) = value else { continue };
            let refuse = |reason| Refusal::new(words.axis_column(), reason);
            let value = self.coordinate(axis, value).map_err(refuse)?;
            let here = self.position.get(axis).copied().unwrap_or_default();
            match (code.tenths, target) {
                (520, _) => self.frame.set_local(axis, value),
                (_, Some((number, true))) => self.frame.set_work_here(number, axis, here, value),
                (_, Some((number, false))) => self.frame.set_work(number, axis, value),
                _ => self.frame.preset(axis, here, value),
            }
        }
        if is_marlin {
            self.extruder(code, words);
        }
        Ok(())
    }

    /// G10: which work offset, and whether it is set by where the machine stands (L20).
    fn table(&self, code: Code, column: u32, words: &mut Words) -> Result<(usize, bool), Refusal> {
        let missing = |what| Refusal::new(column, Reason::Missing { code, what });
        let l = words.take('L', code)?.ok_or(missing("an L word: L2 or L20"))?;
        let here = match libm::round(l * 10.0) as i64 {
            20 => false,
            200 => true,
            _ => {
                let what = "is known with L2 and L20 only";
                return Err(context(code, words.column('L'), what));
            }
        };
        let p = words.take_in('P', code, (0.0, OFFSETS as f64), true)?;
        let p = p.ok_or(missing("a P word, the number of a work offset"))? as usize;
        words.take_in('R', code, (0.0, 0.0), true)?;
        Ok((p.checked_sub(1).unwrap_or(self.frame.active()), here))
    }
}
