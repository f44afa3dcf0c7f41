//! How motors follow the axes.

use super::ConfigError;
use super::motors::MOTORS;
use crate::number::vector::{dot, norm};
use crate::number::{Coord, Range, Scalar};

/// Greatest factor of a motor: mm, or degrees, for one of an axis.
const GREATEST_FACTOR: f64 = 1.0e3;
/// Least of the greatest factor of a motor.
const LEAST_FACTOR: f64 = 1.0e-3;
/// Least part of an axis's motion, as motors see it, that is not that of other axes.
const LEAST_PART: f64 = 1.0e-3;
/// Part of it that is a rounding, in units of the last place.
const ROUNDED: f64 = 100.0;
/// Factors in fixed point: one of them.
const ONE: i64 = 1 << 48;

/// The least and the greatest coordinate of every axis in a region.
pub type Region<const N: usize> = [(Coord, Coord); N];

/// How a motor follows the axes in a region.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Follows<S, const N: usize> {
    /// How far it goes for one of each axis: K.
    pub factors: [S; N],
    /// By how much that is wrong in the region, at most. For a motor at f(x) with the derivatives J, H, T by x, with sums of
    /// magnitudes over all axes: |J - K|, |H|, |T|. All are 0 of a motor that is linear.
    ///
    /// Of what the axes do it makes f' = J x', f'' = J x'' + H x' x', f''' = J x''' + 3 H x' x'' + T x' x' x': its limits would be
    /// less by |J - K| |x'| and so on, and bound the rows of K.
    pub strays: [S; 3],
}

/// Motors whose positions are a function of those of the axes. Planning asks what each does over a region, the servo
/// cycle where it is.
///
/// [`Linear`] is the one there is, and its kind the only one that [`Limits::with_motors`](super::Limits::with_motors) takes: that
/// asks for the whole space. Others (a delta, a SCARA) would be asked cell by cell, with the region that holds the cell.
pub trait Kinematics<S: Scalar, const N: usize, const M: usize> {
    /// Where the motors are with the axes at a place; beyond +-9.2e6 mm they are taken to be there.
    fn positions(&self, axes: &[Coord; N]) -> [Coord; M];

    /// How a motor follows the axes in a region; nothing of one that there is not.
    fn follows(&self, motor: usize, region: &Region<N>) -> Follows<S, N>;
}

/// All coordinates.
pub(super) struct Everywhere<const N: usize>;

impl<const N: usize> Everywhere<N> {
    /// Of all axes.
    pub const AXES: Region<N> = [(Coord::from_raw(i64::MIN), Coord::from_raw(i64::MAX)); N];
}

/// `M` motors, each at a sum of factors times the positions of `N` axes: two belts over two axes, two motors on one axis, an
/// axis that is not quite square to another.
///
/// Axes that no motor is named for have their own drives.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Linear<S, const N: usize, const M: usize> {
    factors: [[S; N]; M],
    /// The same in 1/2^48: a position is then the same sum of whole numbers however it was reached.
    fixed: [[i64; N]; M],
}

/// A factor in fixed point.
pub(crate) fn fixed<S: Scalar>(factor: S) -> i64 {
    // By a power of two: nothing is rounded but what is below 2^-48.
    (factor * S::of(ONE as f64)).to_i64()
}

/// A factor in fixed point times a coordinate; at the ends of the numbers where it is beyond.
#[inline]
pub(crate) fn times(factor: i64, raw: i64) -> i64 {
    match factor {
        0 => 0,
        ONE => raw,
        _ if factor == -ONE => raw.saturating_neg(),
        _ => {
            let product = (i128::from(factor) * i128::from(raw)) >> 48;
            product.clamp(i128::from(i64::MIN), i128::from(i64::MAX)) as i64
        }
    }
}

/// Whether the factors of motors make sense.
pub(super) fn check_factors<'a, S: Scalar, const N: usize>(
    rows: &(impl Iterator<Item = &'a [S; N]> + Clone),
) -> Result<(), ConfigError> {
    let range = Range::new(-GREATEST_FACTOR, GREATEST_FACTOR);
    for (motor, row) in rows.clone().enumerate() {
        let (mut greatest, mut at) = (S::ZERO, 0);
        for (axis, factor) in row.iter().enumerate() {
            let named = |error| ConfigError::MotorFactor { motor, axis, error };
            range.check(*factor).map_err(named)?;
            if factor.abs() > greatest {
                (greatest, at) = (factor.abs(), axis);
            }
        }
        let named = |error| ConfigError::MotorFactor { motor, axis: at, error };
        Range::new(LEAST_FACTOR, GREATEST_FACTOR).check(greatest).map_err(named)?;
    }
    // Whether no axis could move with others while all motors stand still: Gram and Schmidt over what the motors see of each.
    let mut seen = [[S::ZERO; MOTORS]; N];
    for axis in 0..N {
        let mut left = [S::ZERO; MOTORS];
        for (left, row) in left.iter_mut().zip(rows.clone()) {
            *left = row.get(axis).copied().unwrap_or(S::ZERO);
        }
        let size = norm(&left);
        if !(size > S::ZERO) {
            continue;
        }
        for left in &mut left {
            *left = *left / size;
        }
        for other in &seen {
            let common = dot(&left, other);
            for (left, other) in left.iter_mut().zip(other) {
                *left = *left - common * *other;
            }
        }
        let mut part = norm(&left);
        if part < S::EPSILON * S::of(ROUNDED) {
            part = S::ZERO;
        }
        let named = |error| ConfigError::Singular { axis, error };
        Range::new(LEAST_PART, 1.0 + LEAST_PART).check(part).map_err(named)?;
        if let Some(slot) = seen.get_mut(axis) {
            *slot = left.map(|left| left / part);
        }
    }
    Ok(())
}

impl<S: Scalar, const N: usize, const M: usize> Linear<S, N, M> {
    /// From the factors of every motor: how far it goes for one of each axis, mm (or degrees) each.
    ///
    /// # Errors
    /// [`ConfigError::MotorFactor`] names the first that is not finite or beyond +-1000, or a motor whose factors are all below
    /// 0.001; [`ConfigError::Singular`] an axis that could move with others without a motor.
    pub fn new(factors: [[S; N]; M]) -> Result<Self, ConfigError> {
        const { assert!(M >= 1 && M <= MOTORS, "1 to 8 motors") };
        check_factors(&factors.iter())?;
        Ok(Self::of(factors))
    }

    fn of(factors: [[S; N]; M]) -> Self {
        Self { factors, fixed: factors.map(|row| row.map(fixed)) }
    }

    /// The factors of every motor.
    pub const fn factors(&self) -> &[[S; N]; M] {
        &self.factors
    }

    /// A motor for every axis, and one more on `axis`: a gantry, which is square as long as its two motors go alike.
    ///
    /// # Errors
    /// [`ConfigError::MotorFactor`] if there is no such axis.
    pub fn gantry(axis: usize) -> Result<Self, ConfigError> {
        const { assert!(M == N + 1, "a gantry has one motor more than axes") };
        Self::new(core::array::from_fn(|motor| unit(if motor < N { motor } else { axis })))
    }
}

impl<S: Scalar, const N: usize> Linear<S, N, N> {
    /// A motor for every axis.
    pub fn direct() -> Self {
        Self::of(core::array::from_fn(unit))
    }

    /// Two belts over the first two axes, CoreXY or H-bot: motors at x + y and x - y, mm of belt; the other axes have a
    /// motor each.
    #[doc(alias = "H-bot")]
    pub fn core_xy() -> Self {
        const { assert!(N >= 2, "CoreXY has two axes at least") };
        let sum = |sign: S| {
            core::array::from_fn(|axis| match axis {
                0 => S::ONE,
                1 => sign,
                _ => S::ZERO,
            })
        };
        Self::of(core::array::from_fn(|motor| match motor {
            0 => sum(S::ONE),
            1 => sum(-S::ONE),
            _ => unit(motor),
        }))
    }

    /// A motor for every axis, of which one is not square to another: while `by` goes one mm, what `axis` stands on takes it
    /// `slope` mm along, which its motor takes back.
    ///
    /// # Errors
    /// As [`Linear::new`]; [`ConfigError::MotorFactor`] if there are no two such axes.
    pub fn skew(axis: usize, by: usize, slope: S) -> Result<Self, ConfigError> {
        let mut factors: [[S; N]; N] = core::array::from_fn(unit);
        let slot = factors.get_mut(axis).filter(|_| axis != by).and_then(|row| row.get_mut(by));
        let Some(slot) = slot else {
            let error = Range::new(0.0, N as f64 - 1.0).refused(axis.max(by) as f64);
            return Err(ConfigError::MotorFactor { motor: axis, axis: by, error });
        };
        *slot = -slope;
        Self::new(factors)
    }
}

/// One of an axis.
fn unit<S: Scalar, const N: usize>(axis: usize) -> [S; N] {
    core::array::from_fn(|i| if i == axis { S::ONE } else { S::ZERO })
}

impl<S: Scalar, const N: usize, const M: usize> Kinematics<S, N, M> for Linear<S, N, M> {
    #[inline]
    fn positions(&self, axes: &[Coord; N]) -> [Coord; M] {
        self.fixed.each_ref().map(|row| {
            let mut sum = 0i64;
            for (factor, at) in row.iter().zip(axes) {
                sum = sum.saturating_add(times(*factor, at.raw()));
            }
            Coord::from_raw(sum)
        })
    }

    fn follows(&self, motor: usize, _: &Region<N>) -> Follows<S, N> {
        let factors = self.factors.get(motor).copied().unwrap_or([S::ZERO; N]);
        Follows { factors, strays: [S::ZERO; 3] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{AxisLimits, Limits, Quantity};

    fn mm(mm: f64) -> Coord {
        Coord::from_mm(mm).unwrap()
    }

    #[test]
    fn belts_add_and_subtract_to_the_last_unit() {
        let belts = Linear::<f32, 3, 3>::core_xy();
        let axes = [Coord::from_raw(123_456_789_012_345), Coord::from_raw(-7), mm(4.0)];
        let raw = belts.positions(&axes).map(Coord::raw);
        assert_eq!(raw, [123_456_789_012_338, 123_456_789_012_352, mm(4.0).raw()]);
        let pair = Linear::<f64, 2, 3>::gantry(1).unwrap();
        assert_eq!(pair.positions(&[mm(1.0), mm(2.0)]), [mm(1.0), mm(2.0), mm(2.0)]);
        let skewed = Linear::<f64, 2, 2>::skew(0, 1, 0.25).unwrap();
        assert_eq!(skewed.positions(&[mm(100.0), mm(-8.0)]), [mm(102.0), mm(-8.0)]);
    }

    /// A factor of an `f32` is kept as it is, far out too; beyond the numbers a position ends, it does not wrap.
    #[test]
    fn positions_are_the_sums_of_exact_products() {
        let factor = 0.017_453_3f32;
        let motors = Linear::<f32, 1, 1>::new([[factor]]).unwrap();
        for at in [1.0e6, -1.0e6, 12.345, -1.0e-12] {
            let [motor] = motors.positions(&[mm(at)]);
            let exact = (i128::from(mm(at).raw()) * i128::from(fixed(factor))) >> 48;
            assert_eq!(i128::from(motor.raw()), exact);
            assert!((motor.to_mm() - at * f64::from(factor)).abs() <= 1.0e-15 * at.abs() + 2.0e-12);
        }
        let geared = Linear::<f64, 1, 1>::new([[-1000.0]]).unwrap();
        assert_eq!(geared.positions(&[mm(1.0e6)]), [Coord::from_raw(i64::MIN)]);
        assert_eq!(geared.positions(&[mm(2.0)]), [mm(-2000.0)]);
    }

    #[test]
    fn what_makes_no_sense_is_named() {
        let factor = |motor: usize, axis: usize, factors: [[f64; 2]; 2]| {
            let error = Linear::new(factors).unwrap_err();
            let ConfigError::MotorFactor { motor: at, axis: by, .. } = error else {
                panic!("{error}")
            };
            assert_eq!((at, by), (motor, axis), "{error}");
        };
        factor(1, 0, [[1.0, 0.0], [f64::NAN, 0.0]]);
        factor(0, 1, [[1.0, -1001.0], [1.0, 1.0]]);
        factor(1, 0, [[1.0, 0.0], [0.0, 0.0]]);
        // Both axes forward and back: the motors do not see the difference.
        let singular = Linear::new([[1.0, 1.0], [-2.0, -2.0]]).unwrap_err();
        assert!(matches!(singular, ConfigError::Singular { axis: 1, .. }), "{singular}");
        let all = Linear::<f64, 3, 2>::new([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]).unwrap_err();
        assert!(matches!(all, ConfigError::Singular { axis: 2, .. }), "{all}");
        // An axis without a motor that is named has its own drive.
        assert!(Linear::<f64, 3, 2>::new([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0]]).is_ok());
        assert!(Linear::<f64, 2, 2>::skew(0, 2, 0.1).is_err());
        assert!(Linear::<f64, 2, 2>::skew(1, 1, 0.1).is_err());
        assert!(Linear::<f64, 2, 3>::gantry(2).is_err());
    }

    /// A motor at the distance from a pivot.
    struct Polar;

    impl Kinematics<f64, 2, 1> for Polar {
        fn positions(&self, axes: &[Coord; 2]) -> [Coord; 1] {
            let [x, y] = axes.map(Coord::to_mm);
            [Coord::from_mm(libm::hypot(x, y)).unwrap_or_default()]
        }
        fn follows(&self, _: usize, _: &Region<2>) -> Follows<f64, 2> {
            Follows { factors: [1.0, 0.0], strays: [2.0, f64::INFINITY, f64::INFINITY] }
        }
    }

    #[test]
    fn limits_of_motors_are_checked() {
        let axis = AxisLimits::linear(200.0, 2000.0, 5.0e4);
        let limits = Limits::new([axis; 2]).unwrap();
        let belts = Linear::<f64, 2, 2>::core_xy();
        let bad = AxisLimits { jerk: 0.0, ..axis };
        let error = limits.with_motors(&belts, [axis, bad]).unwrap_err();
        let ConfigError::MotorLimit { motor: 1, quantity: Quantity::Jerk, .. } = error else {
            panic!("{error}")
        };
        let error = limits.with_motors(&Polar, [axis]).unwrap_err();
        assert_eq!(error, ConfigError::NotLinear { motor: 0 });
        assert_eq!(Polar.positions(&[mm(3.0), mm(4.0)]), [mm(5.0)]);
        let wide = AxisLimits::linear(400.0, 4000.0, 1.0e5);
        let both = limits.with_motors(&belts, [axis, wide]).unwrap();
        let of = |limits: &Limits<f64, 2>, i| limits.motor(i).map(|motor| motor.limits);
        assert_eq!([0, 1, 2].map(|i| of(&both, i)), [Some(axis), Some(wide), None]);
        // The second is held by its axes: only the first is a row of its own.
        assert_eq!(both.motors().count(), 1);
        assert_eq!(both.along(&[0.0, 1.0]).map(f64::to_bits), [2000.0, 5.0e4].map(f64::to_bits));
        let half = core::f64::consts::FRAC_1_SQRT_2;
        let [acceleration, jerk] = both.along(&[half, half]);
        assert!((acceleration - 2000.0 * half).abs() < 1e-9 && (jerk - 5.0e4 * half).abs() < 1e-9);
        assert!((both.along(&[half, -half])[0] - 2000.0 / half).abs() < 1e-9);
        // With more for the axes in a stop the second counts again, and what is not named stays.
        let stop = Limits::new([AxisLimits::linear(1.0, 8000.0, 5.0e5); 2]).unwrap();
        let stops = both.with_more(&stop);
        assert_eq!(stops.motors().count(), 2);
        assert_eq!([0, 1].map(|i| of(&stops, i)), [Some(axis), Some(wide)]);
        assert_eq!(limits.on_motors_of(&both), both);
    }
}
