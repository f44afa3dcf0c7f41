//! The motion over one cell, given speed and acceleration at both of its nodes.

use crate::number::Scalar;

/// Speed squared and acceleration along the path at a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathState<S> {
    /// b = v^2, mm2/s2.
    pub b: S,
    /// Path acceleration, mm/s2.
    pub a: S,
}

impl<S: Scalar> PathState<S> {
    /// At rest.
    pub const REST: Self = Self { b: S::ZERO, a: S::ZERO };
}

/// Path motion s(t) over one cell of length h: the quartic with the speeds and accelerations of
/// both nodes. Its duration follows from the corrected trapezoidal rule, which is exact for a
/// quartic: h = T (v0 + v1) / 2 + T^2 (a0 - a1) / 12.
#[derive(Clone, Copy, Debug)]
pub struct Law<S> {
    pub v0: S,
    pub v1: S,
    pub a0: S,
    pub a1: S,
    /// Duration, s.
    pub time: S,
    /// 1 / duration.
    pub rate: S,
    /// Root of the discriminant, mm/s; positive.
    pub root: S,
    /// Path jerk at the start, its mean, and at the end, mm/s3 (it is linear in t).
    pub jerk: [S; 3],
    /// v1 - v0, mm/s.
    pub gain: S,
    /// (a0 + a1) / 2 - (v1 - v0) / T: what the jerk swings by, up to the factor 6 / T.
    pub twist: S,
}

/// Least admissible ratio of discriminant and mean speed squared. Below it the cell would hardly
/// be crossed; at constant jerk from rest the ratio is 1/9.
const LEAST_ROOT: f64 = 0.01;

impl<S: Scalar> Law<S> {
    /// The motion over a cell of `length` mm, or `None` if there is none with these end states.
    #[inline]
    pub fn new(length: S, from: PathState<S>, to: PathState<S>) -> Option<Self> {
        let (v0, v1) = (from.b.sqrt(), to.b.sqrt());
        let [time, root] = crossing(length, [v0, v1], from.a - to.a)?;
        let rate = S::ONE / time;
        // Never backwards.
        let [early, late] = inner_speeds((v0, from.a), (v1, to.a), time);
        if early < S::ZERO || late < S::ZERO {
            return None;
        }
        let slope = (to.a - from.a) * rate;
        // v1 - v0 from the squares: it keeps its digits.
        let gain = (to.b - from.b) / (v0 + v1);
        let twist = (from.a + to.a) * S::of(0.5) - gain * rate;
        let swing = S::of(6.0) * twist * rate;
        Some(Self {
            v0,
            v1,
            a0: from.a,
            a1: to.a,
            time,
            rate,
            root,
            jerk: [slope - swing, slope, slope + swing],
            gain,
            twist,
        })
    }
}

impl<S: Scalar> Law<S> {
    /// The motion at a constant speed of 1 mm/s.
    pub fn steady(length: S) -> Self {
        Self {
            v0: S::ONE,
            v1: S::ONE,
            a0: S::ZERO,
            a1: S::ZERO,
            time: length,
            rate: S::ONE / length,
            root: S::ONE,
            jerk: [S::ZERO; 3],
            gain: S::ZERO,
            twist: S::ZERO,
        }
    }

    /// The inner Bernstein coefficients of the speed s', mm/s.
    #[inline]
    pub fn inner_speeds(&self) -> [S; 2] {
        inner_speeds((self.v0, self.a0), (self.v1, self.a1), self.time)
    }

    /// Length, mm, of the motion that takes `time` from one state to another.
    pub fn length(from: PathState<S>, to: PathState<S>, time: S) -> S {
        time * (from.b.sqrt() + to.b.sqrt()) * S::of(0.5)
            + time * time * (from.a - to.a) * S::of(1.0 / 12.0)
    }
}

/// The duration of a motion over a cell of `length` mm between two speeds, where the acceleration falls by `fall`, and the root of the
/// discriminant.
#[inline]
pub fn crossing<S: Scalar>(length: S, [v0, v1]: [S; 2], fall: S) -> Option<[S; 2]> {
    let mean = (v0 + v1) * S::of(0.5);
    let tilt = fall * S::of(1.0 / 12.0);
    let square = mean * mean + S::of(4.0) * tilt * length;
    if !(square > S::of(LEAST_ROOT) * mean * mean) {
        return None;
    }
    let root = square.sqrt();
    Some([S::of(2.0) * length / (mean + root), root])
}

#[inline]
fn inner_speeds<S: Scalar>((v0, a0): (S, S), (v1, a1): (S, S), time: S) -> [S; 2] {
    let reach = time * S::of(1.0 / 3.0);
    [v0 + a0 * reach, v1 - a1 * reach]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From rest at constant jerk J over T: h = J T^3 / 6, v = J T^2 / 2, a = J T.
    #[test]
    fn constant_jerk_from_rest_is_exact() {
        let (jerk, time) = (50_000.0f64, 0.02);
        let (h, v, a) = (jerk * time * time * time / 6.0, jerk * time * time / 2.0, jerk * time);
        let law = Law::new(h, PathState::REST, PathState { b: v * v, a }).unwrap();
        assert!((law.time - time).abs() < 1e-15);
        for j in law.jerk {
            assert!((j - jerk).abs() < 1e-6 * jerk);
        }
    }

    #[test]
    fn impossible_states_have_no_law() {
        let brake = PathState { b: 1.0, a: -1.0e3 };
        let push = PathState { b: 1.0, a: 1.0e3 };
        assert!(Law::<f64>::new(1.0, brake, push).is_none());
        assert!(Law::<f64>::new(1.0, PathState::REST, PathState::REST).is_none());
    }
}
