//! What is passed on to the machine: spindle, tools, coolant, outputs; and what printers have of it.

use super::Code;
use super::dialect::{Dialect, Use};
use super::error::{Note, Reason, Refusal};
use super::groups::{Codes, Group};
use super::reader::Reader;
use super::words::Words;

impl Reader {
    /// S, T and the M codes that come before the motion, in the order of RS274/NGC.
    pub(super) fn machine_events(
        &mut self,
        codes: &Codes,
        words: &mut Words,
    ) -> Result<(), Refusal> {
        let spindle = codes.m(Use::Spindle);
        #[cfg(feature = "outputs")]
        let spindle = if self.power(codes, words)? { None } else { spindle };
        if !(self.has_own_speed(codes, words) && spindle.is_none())
            && let Some(speed) = words.take_in('S', Code::SPEED, (0.0, 1.0e6), false)?
        {
            let starts = spindle.is_some_and(|(code, _)| matches!(code.tenths, 30 | 40));
            if !starts && self.spindle != Some(speed) {
                self.push_event(Code::SPEED, Some(speed), false, words.column('S'))?;
            }
            self.spindle = Some(speed);
        }
        let change = codes.m(Use::Tool);
        if let Some(tool) = words.take_in('T', Code::TOOL, (0.0, 99_999.0), true)? {
            if change.is_none_or(|(code, _)| code.tenths != 60) {
                self.push_event(Code::TOOL, Some(tool), false, words.column('T'))?;
            }
            self.tool = Some(tool as u32);
        }
        if let Some((code, column)) = change {
            if code.tenths == 610 {
                let tool = words.take_in('Q', code, (0.0, 99_999.0), true)?;
                let missing = Reason::Missing { code, what: "a Q word, the number of the tool" };
                self.tool = Some(tool.ok_or(Refusal::new(column, missing))? as u32);
            }
            self.loaded = self.tool;
            self.push_event(code, self.tool.map(f64::from), code.tenths == 60, column)?;
        }
        if let Some((code, column)) = spindle {
            let value = match code.tenths {
                30 | 40 => self.spindle,
                190 => {
                    words.take_in('P', code, (0.0, 2.0), true)?;
                    words.take_in('R', code, (-360.0, 360.0), false)?
                }
                _ => None,
            };
            self.push_event(code, value, false, column)?;
        }
        for what in [Use::Mist, Use::Flood, Use::CoolantOff] {
            if let Some((code, column)) = codes.m(what) {
                #[cfg(feature = "outputs")]
                if self.coolant((code, column))? {
                    continue;
                }
                self.push_event(code, None, false, column)?;
            }
        }
        if let Some((code, column)) = codes.m(Use::Override) {
            let has_word = matches!(code.tenths, 500..=530);
            let value = if has_word { words.take_in('P', code, (0.0, 1.0), true)? } else { None };
            self.push_event(code, value, false, column)?;
        }
        if let Some((code, column)) = codes.m(Use::Output) {
            #[cfg(feature = "outputs")]
            if self.switch((code, column), words)? {
                return Ok(());
            }
            let value = words.take_in('P', code, (0.0, 9999.0), true)?;
            let missing = Reason::Missing { code, what: "a P word, the number of the output" };
            let value = value.ok_or(Refusal::new(column, missing))?;
            self.push_event(code, Some(value), false, column)?;
        }
        Ok(())
    }

    /// Whether an S word is none of the spindle's: of printers that of a dwell, a retraction and a tool; the greatest
    /// speed of a lathe beside G50 and G92.
    fn has_own_speed(&self, codes: &Codes, words: &Words) -> bool {
        let once = codes.g(Group::Once).map(|(code, _)| code.tenths);
        if self.settings.dialect == Dialect::Marlin {
            return once == Some(40) || codes.g(Group::Extruder).is_some() || words.has('T');
        }
        once == Some(920) || codes.g(Group::NO_SCALE).is_some()
    }

    /// A code of printers that takes all the words of its line.
    pub(super) fn alone(&mut self, code: Code, what: Use, words: &Words) {
        if what == Use::Skip {
            // Of what is left out because the settings are lenient, that is said already.
            if self.notes().is_empty() {
                self.note(Note::Skipped(code));
            }
            return;
        }
        let word = words.list().iter().find(|word| word.letter == b'S');
        let value = word.and_then(|word| word.value);
        if let Some(percent) =
            value.filter(|percent| code == Code::m(220) && (*percent - 100.0).abs() > 1e-9)
        {
            self.note(Note::FeedShare(percent));
        }
        // One event in an empty list.
        let pushed = self.push_event(code, value, what == Use::PassAndWait, 1);
        debug_assert!(pushed.is_ok(), "an event that is never reported");
    }
}
