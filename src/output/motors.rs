//! Setpoints of motors.

use crate::machine::{Kinematics, Linear};
use crate::number::Scalar;
use crate::number::vector::dot;
use crate::servo::Setpoint;

impl<S: Scalar, const N: usize, const M: usize> Linear<S, N, M> {
    /// The setpoint of the motors: their positions, velocities and accelerations in the place of those of the axes, so that every
    /// output of this module drives motors as it does axes.
    ///
    /// Fixed-point parts are exact sums: a position does not depend on the way to it.
    ///
    /// Cost: 2 `N` `M` multiplications in the scalar and `N` `M` additions of whole numbers; a factor other than 0 and +-1 is
    /// a product of 128 bits.
    #[inline]
    pub fn setpoint(&self, axes: &Setpoint<S, N>) -> Setpoint<S, M> {
        let of = |axes: &[S; N]| self.factors().each_ref().map(|row| dot(row, axes));
        Setpoint {
            origin: self.positions(&axes.origin),
            offset: of(&axes.offset),
            velocity: of(&axes.velocity),
            acceleration: of(&axes.acceleration),
            path_origin: axes.path_origin,
            path_offset: axes.path_offset,
            path_speed: axes.path_speed,
            tag: axes.tag,
            activity: axes.activity,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::Coord;

    #[test]
    fn motors_move_as_the_axes_do() {
        let belts = Linear::<f32, 2, 2>::core_xy();
        let at = [Coord::from_nm(3_000_000).unwrap(), Coord::from_nm(-1_000_000).unwrap()];
        let axes = Setpoint {
            origin: at,
            offset: [0.5, 0.25],
            velocity: [10.0, -30.0],
            acceleration: [-4.0, 1.0],
            path_speed: 5.0,
            tag: 9,
            ..Setpoint::REST
        };
        let motors = belts.setpoint(&axes);
        assert_eq!([0, 1].map(|i| motors.position_nm(i)), [2_750_000, 4_250_000]);
        assert_eq!(motors.velocity.map(f32::to_bits), [-20.0f32, 40.0].map(f32::to_bits));
        assert_eq!(motors.acceleration.map(f32::to_bits), [-3.0f32, -5.0].map(f32::to_bits));
        assert_eq!((motors.tag, motors.path_speed.to_bits()), (9, 5.0f32.to_bits()));
    }
}
