//! The codes of a line, sorted into modal groups: of each group at most one.

use super::Code;
use super::dialect::{Dialect, Refused, Use};
use super::error::{Note, Reason, Refusal};
use super::words::Words;

/// Modal groups of G codes, after RS274/NGC and LinuxCNC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// G4, G10, G28, G30, G52, G92 and theirs.
    Once,
    /// G0 to G5.3, G31, G38.2 to G38.5, G73, G81 to G83.
    Motion,
    /// G80. (In LinuxCNC of the group above; in most others it may stand beside G0 to G3.)
    CycleEnd,
    /// G17 to G19.
    Plane,
    /// G90, G91.
    Distance,
    /// G90.1, G91.1.
    Centre,
    /// G93, G94.
    Feed,
    /// G20, G21.
    Units,
    /// G40.
    Radius,
    /// G43, G43.1, G49.
    Length,
    /// G98, G99.
    Return,
    /// G54 to G59.3.
    Offset,
    /// G61, G61.1, G64.
    Path,
    /// G68, G69.
    Rotation,
    /// G53.
    Machine,
    /// G9.
    Stop,
    /// Codes that switch off what is not there: G8, G15, G50, G97.
    Off(u8),
    /// Of printers: G10, G11.
    Extruder,
}

/// Number of groups.
const GROUPS: usize = 21;

impl Group {
    /// G50.
    pub const NO_SCALE: Self = Self::Off(2);

    const fn index(self) -> usize {
        match self {
            Self::Once => 0,
            Self::Motion => 1,
            Self::Plane => 2,
            Self::Distance => 3,
            Self::Centre => 4,
            Self::Feed => 5,
            Self::Units => 6,
            Self::Radius => 7,
            Self::Length => 8,
            Self::Return => 9,
            Self::Offset => 10,
            Self::Path => 11,
            Self::Rotation => 12,
            Self::Machine => 13,
            Self::Stop => 14,
            Self::Extruder => 15,
            Self::CycleEnd => 16,
            Self::Off(which) => 17 + (which & 3) as usize,
        }
    }
}

/// The group of a G code, or why it is refused; `None` if it is not known.
pub const fn group(tenths: u16, dialect: Dialect) -> Option<Result<Group, Refused>> {
    match dialect {
        Dialect::Marlin => printer(tenths),
        Dialect::LinuxCnc | Dialect::Grbl => mill(tenths),
    }
}

const fn no(what: &'static str) -> Result<Group, Refused> {
    Err(Refused { what, harmless: false })
}

const fn mill(tenths: u16) -> Option<Result<Group, Refused>> {
    Some(Ok(match tenths {
        40 | 100 | 280 | 281 | 300 | 301 | 520 | 920..=923 => Group::Once,
        52 | 53 if !cfg!(feature = "nurbs") => {
            return Some(no("a NURBS block, for which the feature `nurbs` is needed"));
        }
        0 | 10 | 20 | 30 | 50..=53 | 310 | 382..=385 | 730 | 810 | 820 | 830 => Group::Motion,
        800 => Group::CycleEnd,
        90 => Group::Stop,
        170 | 180 | 190 => Group::Plane,
        200 | 210 => Group::Units,
        400 => Group::Radius,
        430 | 431 | 490 => Group::Length,
        530 => Group::Machine,
        540 | 550 | 560 | 570 | 580 | 590..=593 => Group::Offset,
        610 | 611 | 640 => Group::Path,
        680 | 690 => Group::Rotation,
        900 | 910 => Group::Distance,
        901 | 911 => Group::Centre,
        930 | 940 => Group::Feed,
        980 | 990 => Group::Return,
        80 => Group::Off(0),
        150 => Group::Off(1),
        500 => Group::NO_SCALE,
        970 => Group::Off(3),
        70 => return Some(no("diameters of a lathe")),
        110 | 120 | 130 | 150..=169 => return Some(no("polar coordinates or pockets")),
        171 | 181 | 191 => return Some(no("a plane of U, V and W")),
        220 | 230 | 260 | 270 | 290 => return Some(no("a procedure of the machine's own")),
        380..=389 => return Some(no("another kind of probing")),
        320..=339 => return Some(no("thread cutting, which needs a spindle encoder")),
        410..=429 => return Some(no("tool radius compensation")),
        432 | 440 | 450..=489 => return Some(no("another tool offset")),
        510 => return Some(no("scaling or mirroring")),
        600 => return Some(no("approach from one side")),
        620..=639 => return Some(no("another path mode")),
        650..=679 => return Some(no("a macro")),
        682..=689 => return Some(no("a tilted plane")),
        700..=729 => return Some(no("old inch and metric codes, or a cycle of a lathe")),
        740..=799 => return Some(no("a cycle of a lathe or for tapping")),
        840..=899 => return Some(no("a canned cycle that needs a spindle")),
        950 => return Some(no("feed per revolution, which needs a spindle encoder")),
        960 => return Some(no("constant surface speed")),
        _ => return None,
    }))
}

/// Codes of printers. Some numbers that are harmless elsewhere move a printer: G30, G42, G61.
const fn printer(tenths: u16) -> Option<Result<Group, Refused>> {
    Some(Ok(match tenths {
        40 | 280 | 920 => Group::Once,
        0 | 10 | 20 | 30 | 50 => Group::Motion,
        800 => Group::CycleEnd,
        100 | 110 => Group::Extruder,
        170 | 180 | 190 => Group::Plane,
        200 | 210 => Group::Units,
        400 => Group::Radius,
        490 => Group::Length,
        530 => Group::Machine,
        540 | 550 | 560 | 570 | 580 | 590..=593 => Group::Offset,
        640 => Group::Path,
        900 | 910 => Group::Distance,
        940 => Group::Feed,
        290 => return Some(Err(Refused { what: "levelling of the bed", harmless: true })),
        300 | 310 | 320 | 330 | 340 | 350 | 380..=389 | 760 => return Some(no("probing")),
        120 | 260 | 270 => return Some(no("a procedure of the printer's own")),
        420 => return Some(no("a move to a point of the bed's map")),
        600 | 610 => return Some(no("saving and restoring a position")),
        _ => return None,
    }))
}

/// A code and where it stands.
pub type Found = (Code, u32);

/// The codes of a line.
#[derive(Clone, Copy, Debug, Default)]
pub struct Codes {
    g: [Option<Found>; GROUPS],
    /// By [`slot`].
    m: [Option<Found>; SLOTS],
    /// A code that stands alone in its line and takes all its words.
    pub alone: Option<(Found, Use)>,
    /// How many G and M codes there are.
    count: usize,
}

const SLOTS: usize = 9;

const fn slot(what: Use) -> Option<usize> {
    match what {
        Use::Stop | Use::End => Some(0),
        Use::Call | Use::Return => Some(1),
        Use::Tool => Some(2),
        Use::Spindle => Some(3),
        Use::Mist => Some(4),
        Use::Flood => Some(5),
        Use::CoolantOff => Some(6),
        Use::Override => Some(7),
        Use::Output => Some(8),
        Use::Pass | Use::PassAndWait | Use::Skip => None,
    }
}

/// The tenths of a code's number, if it has one.
pub fn tenths(value: f64) -> Option<u16> {
    let tenths = libm::round(value * 10.0);
    let is_code = (0.0..60_000.0).contains(&tenths) && (tenths - value * 10.0).abs() < 1.0e-6;
    is_code.then_some(tenths as u16)
}

impl Codes {
    /// Sorts the codes of a line. What is refused and can be left out is told to `note` if the settings are
    /// lenient.
    pub fn sort(
        words: &mut Words,
        dialect: Dialect,
        lenient: bool,
        note: &mut impl FnMut(Note),
    ) -> Result<Self, Refusal> {
        let mut codes = Self::default();
        let count = words.list().len();
        for at in 0..count {
            let Some(word) = words.list().get(at).copied() else { break };
            let letter = char::from(word.letter);
            if !matches!(letter, 'G' | 'M') {
                continue;
            }
            let refuse = |reason| Refusal::new(word.column, reason);
            let value = word.value.ok_or(refuse(Reason::NoNumber(letter)))?;
            let bad = Reason::Range { letter, value, least: 0.0, greatest: 5_999.9, whole: false };
            let code = Code { letter, tenths: tenths(value).ok_or(refuse(bad))? };
            words.mark(at, code);
            codes.count += 1;
            let known = if letter == 'G' {
                group(code.tenths, dialect).map(|found| found.map(Slot::G))
            } else {
                dialect.m_code(code).map(|found| found.map(Slot::M))
            };
            match known {
                Some(Ok(kept)) => codes.put(kept, (code, word.column))?,
                // M92 for the extruder only.
                Some(Err(_))
                    if code == Code::m(92) && dialect == Dialect::Marlin && !words.has_axes() =>
                {
                    codes.put(Slot::M(Use::Skip), (code, word.column))?;
                }
                Some(Err(Refused { what, harmless })) => {
                    let reason = Reason::Unsupported { code, what, harmless };
                    if !(harmless && lenient) {
                        return Err(refuse(reason));
                    }
                    note(Note::LeftOut(reason));
                    codes.put(Slot::M(Use::Skip), (code, word.column))?;
                }
                None => return Err(refuse(Reason::Unknown(code))),
            }
        }
        codes.check()?;
        Ok(codes)
    }

    fn put(&mut self, kept: Slot, found: Found) -> Result<(), Refusal> {
        let slot = match kept {
            Slot::G(group) => self.g.get_mut(group.index()),
            Slot::M(what) => {
                let Some(slot) = slot(what) else {
                    if let Some((before, _)) = self.alone {
                        return Err(Refusal::new(found.1, Reason::Group(before.0, found.0)));
                    }
                    self.alone = Some((found, what));
                    return Ok(());
                };
                self.m.get_mut(slot)
            }
        };
        if let Some(slot) = slot {
            if let Some(before) = slot {
                return Err(Refusal::new(found.1, Reason::Group(before.0, found.0)));
            }
            *slot = Some(found);
        }
        Ok(())
    }

    fn check(&self) -> Result<(), Refusal> {
        if let (Some((found, _)), true) = (self.alone, self.count > 1) {
            let what = "must be the only code of its line";
            return Err(Refusal::new(found.1, Reason::Context { code: found.0, what }));
        }
        if let (Some(end), Some(cycle)) = (self.g(Group::CycleEnd), self.g(Group::Motion))
            && cycle.0.tenths >= 730
        {
            return Err(Refusal::new(end.1.max(cycle.1), Reason::Group(cycle.0, end.0)));
        }
        // M9 goes with neither M7 nor M8.
        if let Some(off) = self.m(Use::CoolantOff)
            && let Some(on) = self.m(Use::Mist).or(self.m(Use::Flood))
        {
            return Err(Refusal::new(off.1.max(on.1), Reason::Group(on.0, off.0)));
        }
        if let (Some(end), Some(call)) = (self.m(Use::Stop), self.m(Use::Call)) {
            return Err(Refusal::new(end.1.max(call.1), Reason::Group(call.0, end.0)));
        }
        Ok(())
    }

    /// The code of a group.
    pub fn g(&self, group: Group) -> Option<Found> {
        self.g.get(group.index()).copied().flatten()
    }

    /// The M code for something.
    pub fn m(&self, what: Use) -> Option<Found> {
        slot(what).and_then(|slot| self.m.get(slot).copied().flatten())
    }

    /// The stop, the call or the end of the line, or its exact stop.
    pub fn last(&self) -> Option<Found> {
        self.m(Use::Stop).or(self.m(Use::Call)).or(self.g(Group::Stop))
    }

    /// The first code that is none of these.
    pub fn other_than(&self, these: [Code; 2]) -> Option<Found> {
        let all = self.g.iter().chain(&self.m).flatten().copied();
        all.chain(self.alone.map(|(found, _)| found)).find(|(code, _)| !these.contains(code))
    }

    /// The first code of another group than these.
    pub fn beside(&self, these: &[Group]) -> Option<Found> {
        let own = |index: usize| these.iter().any(|group| group.index() == index);
        let other = self.g.iter().enumerate().filter(|(index, _)| !own(*index));
        let mut all = other.map(|(_, found)| found).chain(&self.m).flatten().copied();
        all.next().or(self.alone.map(|(found, _)| found))
    }

    /// Whether there is an M code.
    pub fn has_m(&self) -> bool {
        self.m.iter().any(Option::is_some)
    }

    /// Whether the axis words of the line belong to another code than that of the motion.
    pub fn takes_axes(&self) -> bool {
        let once = self.g(Group::Once).is_some_and(|(code, _)| !matches!(code.tenths, 921..=923));
        let length = self.g(Group::Length).is_some_and(|(code, _)| code.tenths == 431);
        let rotation = self.g(Group::Rotation).is_some_and(|(code, _)| code.tenths == 680);
        once || length || rotation
    }

    /// Of codes that take axis words and are no motion there is at most one in a line, and no motion code beside
    /// it.
    pub fn check_one_taker(&self, (code, column): Found) -> Result<(), Refusal> {
        for group in [Group::Once, Group::Length, Group::Rotation, Group::Motion, Group::Machine] {
            if let Some((other, place)) = self.g(group)
                && other != code
                && !matches!(other.tenths, 40 | 281 | 301 | 430 | 490 | 690 | 800 | 921..=923)
            {
                return Err(Refusal::new(place.max(column), Reason::Both(code, other)));
            }
        }
        Ok(())
    }
}

/// Where a code is kept.
#[derive(Clone, Copy)]
enum Slot {
    G(Group),
    M(Use),
}
