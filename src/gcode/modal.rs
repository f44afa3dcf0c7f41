//! The modes in force.

use super::Code;

/// What axis words alone do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Nothing is in force (G80).
    None,
    Rapid,
    Feed,
    Clockwise,
    CounterClockwise,
    Cubic,
    Quadratic,
    /// Between G5.2 and G5.3.
    Nurbs,
    Cycle(Cycle),
}

/// Canned cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cycle {
    /// G73.
    ChipBreak,
    /// G81.
    Drill,
    /// G82.
    Counterbore,
    /// G83.
    Peck,
}

impl Mode {
    /// The mode of a code of its group.
    pub const fn of(code: Code) -> Self {
        match code.tenths {
            0 => Self::Rapid,
            10 => Self::Feed,
            20 => Self::Clockwise,
            30 => Self::CounterClockwise,
            50 => Self::Cubic,
            51 => Self::Quadratic,
            52 => Self::Nurbs,
            730 => Self::Cycle(Cycle::ChipBreak),
            810 => Self::Cycle(Cycle::Drill),
            820 => Self::Cycle(Cycle::Counterbore),
            830 => Self::Cycle(Cycle::Peck),
            _ => Self::None,
        }
    }

    /// Its code.
    pub const fn code(self) -> Code {
        Code::g(match self {
            Self::None => 800,
            Self::Rapid => 0,
            Self::Feed => 10,
            Self::Clockwise => 20,
            Self::CounterClockwise => 30,
            Self::Cubic => 50,
            Self::Quadratic => 51,
            Self::Nurbs => 52,
            Self::Cycle(Cycle::ChipBreak) => 730,
            Self::Cycle(Cycle::Drill) => 810,
            Self::Cycle(Cycle::Counterbore) => 820,
            Self::Cycle(Cycle::Peck) => 830,
        })
    }

    pub const fn is_arc(self) -> bool {
        matches!(self, Self::Clockwise | Self::CounterClockwise)
    }
}

/// The plane of arcs, cycles and rotations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    Xy,
    Zx,
    Yz,
}

impl Plane {
    /// First and second axis.
    pub const fn axes(self) -> (usize, usize) {
        match self {
            Self::Xy => (0, 1),
            Self::Zx => (2, 0),
            Self::Yz => (1, 2),
        }
    }

    /// Letters of the centre's offsets in these axes.
    pub const fn centre_letters(self) -> (char, char) {
        match self {
            Self::Xy => ('I', 'J'),
            Self::Zx => ('K', 'I'),
            Self::Yz => ('J', 'K'),
        }
    }

    /// The axis across it.
    pub const fn across(self) -> usize {
        match self {
            Self::Xy => 2,
            Self::Zx => 1,
            Self::Yz => 0,
        }
    }
}

/// The modes.
#[derive(Clone, Copy, Debug)]
pub struct Modal {
    pub mode: Mode,
    pub plane: Plane,
    pub inches: bool,
    pub relative: bool,
    pub absolute_centre: bool,
    pub inverse_time: bool,
    pub exact_stop: bool,
    /// G64 P, mm.
    pub tolerance: Option<f64>,
    /// G98: cycles end on the level they began on.
    pub to_initial: bool,
}

impl Modal {
    pub const fn new(mode: Mode) -> Self {
        Self {
            mode,
            plane: Plane::Xy,
            inches: false,
            relative: false,
            absolute_centre: false,
            inverse_time: false,
            exact_stop: false,
            tolerance: None,
            to_initial: true,
        }
    }
}
