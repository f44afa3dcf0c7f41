//! Where the program's zero lies: work offsets, shifts, length of the tool, rotation, reference points.

use super::{AXES, Code};
use crate::number::Coord;

/// Work offsets: G54 to G59, G59.1 to G59.3.
pub const OFFSETS: usize = 9;
/// Lengths that a tool table holds.
pub const TOOLS: usize = 32;

/// A point over all axes, in the machine.
pub type Place = [Coord; AXES];

/// The sum of two coordinates. (Four offsets and a value are well within the range.)
pub fn sum(a: Coord, b: Coord) -> Coord {
    Coord::from_raw(a.raw().saturating_add(b.raw()))
}

/// Whether a number is whole.
pub fn is_whole(value: f64) -> bool {
    (libm::trunc(value) - value).abs() <= 0.0
}

/// Their difference.
pub fn difference(a: Coord, b: Coord) -> Coord {
    Coord::from_raw(a.raw().saturating_sub(b.raw()))
}

/// What the machine brings along: offsets, tools, reference points.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Setup {
    /// Work offsets of G54 to G59.3; one that is `None` must be set by the program before it is selected. G54 is
    /// zero if nothing is said.
    pub work: [Option<Place>; OFFSETS],
    /// Where G28 and G30 go; the machine's zero if nothing is said, as LinuxCNC and grbl have it.
    pub reference: [Place; 2],
    /// Tools by number, and their lengths, for G43.
    pub tools: [Option<(u32, Coord)>; TOOLS],
}

impl Setup {
    /// A machine that brings nothing.
    pub const NONE: Self =
        Self { work: [None; OFFSETS], reference: [[Coord::ZERO; AXES]; 2], tools: [None; TOOLS] };
}

impl Default for Setup {
    fn default() -> Self {
        Self::NONE
    }
}

/// A rotation of the program in a plane (G68).
#[derive(Clone, Copy, Debug)]
pub struct Rotation {
    pub plane: (usize, usize),
    /// About this point of the program.
    centre: (Coord, Coord),
    cos: f64,
    sin: f64,
}

impl Rotation {
    /// By an angle, degrees. Quarter turns are exact.
    pub fn new(plane: (usize, usize), centre: (Coord, Coord), degrees: f64) -> Self {
        let turn = libm::fmod(degrees, 360.0);
        let quarter = turn / 90.0;
        let (sin, cos) = if is_whole(quarter) {
            match (quarter as i32).rem_euclid(4) {
                0 => (0.0, 1.0),
                1 => (1.0, 0.0),
                2 => (0.0, -1.0),
                _ => (-1.0, 0.0),
            }
        } else {
            let radians = turn.to_radians();
            (libm::sin(radians), libm::cos(radians))
        };
        Self { plane, centre, cos, sin }
    }

    /// A vector of the program in the machine.
    pub fn vector(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.cos * x - self.sin * y, self.sin * x + self.cos * y)
    }

    fn point(&self, (x, y): (Coord, Coord)) -> (Coord, Coord) {
        let radius = self.vector((x.minus(self.centre.0), y.minus(self.centre.1)));
        (self.centre.0.plus(radius.0), self.centre.1.plus(radius.1))
    }

    fn back(&self, (x, y): (Coord, Coord)) -> (Coord, Coord) {
        let (x, y): (f64, f64) = (x.minus(self.centre.0), y.minus(self.centre.1));
        let radius = (self.cos * x + self.sin * y, self.cos * y - self.sin * x);
        (self.centre.0.plus(radius.0), self.centre.1.plus(radius.1))
    }
}

/// Which code has set the shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shift {
    None,
    /// G92.
    Preset,
    /// G52.
    Local,
}

/// From the program's coordinates to the machine's.
#[derive(Clone, Debug)]
pub struct Frame {
    work: [Option<Place>; OFFSETS],
    active: usize,
    shift: Place,
    kind: Shift,
    /// The last shift of G92 or G52, for G92.3: they share it, as in LinuxCNC.
    aside: Place,
    /// Length of the tool, along Z.
    tool: Coord,
    pub rotation: Option<Rotation>,
    pub reference: [Place; 2],
}

/// Index of Z, along which tools have their length.
pub const Z: usize = 2;

impl Frame {
    pub fn new(setup: &Setup) -> Self {
        let mut work = setup.work;
        if let Some(first) = work.first_mut() {
            *first = Some(first.unwrap_or_default());
        }
        Self {
            work,
            active: 0,
            shift: Place::default(),
            kind: Shift::None,
            aside: Place::default(),
            tool: Coord::ZERO,
            rotation: None,
            reference: setup.reference,
        }
    }

    /// Number of the work offset in force, from 0.
    pub const fn active(&self) -> usize {
        self.active
    }

    /// Selects a work offset; `false` if nobody has set it.
    pub fn select(&mut self, number: usize) -> bool {
        let known = matches!(self.work.get(number), Some(Some(_)));
        if known {
            self.active = number;
        }
        known
    }

    /// A work offset, if somebody has set it.
    pub fn work_of(&self, number: usize) -> Option<Place> {
        self.work.get(number).copied().flatten()
    }

    /// The shift in force.
    pub const fn shift_in_force(&self) -> Place {
        self.shift
    }

    /// Length of the tool in force.
    pub const fn tool_length(&self) -> Coord {
        self.tool
    }

    fn work(&self, number: usize, axis: usize) -> Coord {
        let place = self.work.get(number).copied().flatten().unwrap_or_default();
        place.get(axis).copied().unwrap_or_default()
    }

    /// G10 L2: where the zero of a work offset lies.
    pub fn set_work(&mut self, number: usize, axis: usize, value: Coord) {
        if let Some(slot) = self.work.get_mut(number) {
            let mut place = slot.unwrap_or_default();
            if let Some(coord) = place.get_mut(axis) {
                *coord = value;
            }
            *slot = Some(place);
        }
    }

    /// G10 L20: so that the machine's place is this of the program.
    pub fn set_work_here(&mut self, number: usize, axis: usize, here: Coord, value: Coord) {
        let rest = sum(self.shift.get(axis).copied().unwrap_or_default(), self.length(axis));
        self.set_work(number, axis, difference(difference(here, rest), value));
    }

    /// What the tool adds to an axis.
    fn length(&self, axis: usize) -> Coord {
        if axis == Z { self.tool } else { Coord::ZERO }
    }

    /// Length of the tool in force (G43, G43.1; 0 by G49).
    pub fn set_tool(&mut self, length: Coord) {
        self.tool = length;
    }

    /// Sum of all offsets of an axis.
    pub fn offset(&self, axis: usize) -> Coord {
        let shift = self.shift.get(axis).copied().unwrap_or_default();
        sum(sum(self.work(self.active, axis), shift), self.length(axis))
    }

    /// Which code has set the shift in force.
    pub const fn shift_kind(&self) -> Shift {
        self.kind
    }

    /// G92: so that the machine's place is this of the program.
    pub fn preset(&mut self, axis: usize, here: Coord, value: Coord) {
        let rest = sum(self.work(self.active, axis), self.length(axis));
        if let Some(shift) = self.shift.get_mut(axis) {
            *shift = difference(difference(here, rest), value);
            self.kind = Shift::Preset;
        }
        self.aside = self.shift;
    }

    /// G52: a zero within the work offset.
    pub fn set_local(&mut self, axis: usize, value: Coord) {
        if let Some(shift) = self.shift.get_mut(axis) {
            *shift = value;
        }
        self.aside = self.shift;
        self.kind = if self.shift == Place::default() { Shift::None } else { Shift::Local };
    }

    /// G92.1 and G92.2: no shift; after the latter, G92.3 brings it back.
    pub fn clear_shift(&mut self, keep: bool) {
        if !keep {
            self.aside = Place::default();
        }
        self.shift = Place::default();
        self.kind = Shift::None;
    }

    /// The shift of an axis is gone (G28 of printers).
    pub fn clear_shift_of(&mut self, axis: usize) {
        if let Some(shift) = self.shift.get_mut(axis) {
            *shift = Coord::ZERO;
        }
        self.aside = self.shift;
        if self.shift == Place::default() {
            self.kind = Shift::None;
        }
    }

    /// G92.3: the last shift of G92 or G52, if G92.1 has not cleared it.
    pub fn restore_shift(&mut self) {
        self.shift = self.aside;
        self.kind = if self.shift == Place::default() { Shift::None } else { Shift::Preset };
    }

    /// The program's coordinates of a place in a plane.
    pub fn in_program(&self, place: &Place, (p, q): (usize, usize)) -> (Coord, Coord) {
        let at = |axis: usize| place.get(axis).copied().unwrap_or_default();
        let plain = (difference(at(p), self.offset(p)), difference(at(q), self.offset(q)));
        self.rotation.map_or(plain, |rotation| rotation.back(plain))
    }

    /// The machine's of a point of the program in a plane.
    pub fn in_machine(&self, point: (Coord, Coord), (p, q): (usize, usize)) -> (Coord, Coord) {
        let turned = self.rotation.map_or(point, |rotation| rotation.point(point));
        (sum(turned.0, self.offset(p)), sum(turned.1, self.offset(q)))
    }

    /// A vector of the program in a plane, mm, in the machine.
    pub fn vector(&self, plain: (f64, f64)) -> (f64, f64) {
        self.rotation.map_or(plain, |rotation| rotation.vector(plain))
    }
}

/// The code of a work offset.
pub const fn offset_code(number: usize) -> Code {
    Code::g(match number {
        0..=5 => 540 + 10 * number as u16,
        _ => 585 + number as u16,
    })
}
