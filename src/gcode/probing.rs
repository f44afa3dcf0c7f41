//! Probes: G38.2 to G38.5, and G31.

use super::error::{Reason, Refusal};
use super::groups::{Codes, Found, Group};
use super::is_rotary;
use super::modal::Mode;
use super::offsets::Place;
use super::reader::Reader;
use super::words::Words;
use crate::block::Feed;

/// A probe: a straight move that ends early on the probe's input. It begins when everything before it is done. Where the machine then
/// stands is for the caller to say, by [`Reader::set_position`]: until then no line is read.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ProbeMove {
    /// Where it ends without contact.
    pub to: Place,
    /// mm/s along the line.
    pub feed: f64,
    /// Whether it ends when the probe closes (G38.2, G38.3, G31) or when it opens (G38.4, G38.5).
    pub closes: bool,
    /// Whether it is an error of the program if that does not come (G38.2, G38.4).
    pub required: bool,
    /// Number of its line.
    pub tag: u32,
}

/// Whether a code is a probe.
pub(super) const fn is_probe(tenths: u16) -> bool {
    matches!(tenths, 310 | 382..=385)
}

impl Reader {
    /// The probe of a line. The motion mode ends with it.
    pub(super) fn probe(
        &mut self,
        found: Found,
        codes: &Codes,
        words: &mut Words,
    ) -> Result<(), Refusal> {
        let (code, column) = found;
        if codes.takes_axes() || !words.has_axes() {
            return Err(Refusal::new(column, Reason::Missing { code, what: "axis words" }));
        }
        if self.modal.inverse_time {
            let what = "needs a feed per minute (G94)";
            return Err(Refusal::new(column, Reason::Context { code, what }));
        }
        let values = words.take_axes(code)?;
        let machine = codes.g(Group::Machine).is_some();
        let to = self.target(&values, machine).map_err(|reason| words.blame(reason))?;
        let from = self.position;
        if to == from {
            let what = "has no way to go";
            return Err(Refusal::new(column, Reason::Context { code, what }));
        }
        self.modal.mode = Mode::Feed;
        let own = to.iter().zip(&from).enumerate();
        let linear = own.into_iter().any(|(axis, (to, from))| !is_rotary(axis) && to != from);
        let feed = self.speed(found, linear, words);
        self.modal.mode = Mode::None;
        let Feed::PerSecond(feed) = feed? else {
            return Err(Refusal::new(column, Reason::Missing { code, what: "a feed" }));
        };
        self.set_named(&values);
        (self.curve, self.series) = (None, None);
        self.position = to;
        let closes = !matches!(code.tenths, 384 | 385);
        let required = matches!(code.tenths, 382 | 384);
        self.set_probe(ProbeMove { to, feed, closes, required, tag: self.line });
        Ok(())
    }
}
