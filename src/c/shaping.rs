//! Input shaping for C: how an axis is shaped is part of the configuration, and of a library with the feature `shaping` the setpoints
//! are the shaped ones.

use super::types::{splineway_config, splineway_result};
#[cfg(feature = "shaping")]
use {
    super::ready,
    super::types::{SPLINEWAY_AXES, SPLINEWAY_HISTORY, splineway_core},
    crate::machine::Config,
    crate::output::{Shape, Shaper, ShaperKind},
};

/// How an axis is shaped.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum splineway_shaper {
    /// Not at all; it waits for the axes that are.
    NONE = 0,
    /// Two impulses, half a period apart: nothing is left of a vibration at exactly the frequency given. The shortest.
    ZV = 1,
    /// Three impulses over three quarters of a period: as exact, and wider.
    MZV = 2,
    /// Three impulses over a period: at the frequency 5 % of the vibration is left, and no more than that from 0.82 to 1.18 of it.
    EI = 3,
    /// A half wave over one and a half periods: what lies above the frequency is damped too.
    SMOOTH = 4,
}

/// An axis that vibrates, and what is to be done about it: all zeros, nothing.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_shape {
    /// A number of `splineway_shaper`. Other than `NONE` it needs a library with the feature `shaping`.
    pub kind: u32,
    /// Frequency of the vibration, Hz, as it is seen (with its damping).
    pub frequency: f32,
    /// Damping ratio of the vibration, 0 to 0.5; 0.05 to 0.1 as a rule.
    pub damping: f32,
}

/// The shaper of a core, set up where it is.
#[cfg(feature = "shaping")]
pub(super) type CShaper = Shaper<f32, SPLINEWAY_AXES, SPLINEWAY_HISTORY>;

/// Sets the shaper up, and asks the motion for what it takes. Returns its delay, s.
#[cfg(feature = "shaping")]
pub(super) fn shape(
    shaper: &mut CShaper,
    c: &splineway_config,
    config: &mut Config<f32, SPLINEWAY_AXES>,
) -> Result<f32, splineway_result> {
    let mut shapes = [None; SPLINEWAY_AXES];
    for (slot, shape) in shapes.iter_mut().zip(c.shape) {
        let kind = match shape.kind {
            0 => continue,
            1 => ShaperKind::Zv,
            2 => ShaperKind::Mzv,
            3 => ShaperKind::Ei,
            4 => ShaperKind::Smooth,
            _ => return Err(splineway_result::CONFIG),
        };
        let (frequency, damping) = (shape.frequency.into(), shape.damping.into());
        *slot = Some(Shape { kind, frequency, damping });
    }
    shaper.set(shapes, config).map_err(|_| splineway_result::CONFIG)?;
    config.follower = shaper.follower(config);
    Ok(shaper.delay() as f32)
}

/// A library without shapers refuses to be told of one.
#[cfg(not(feature = "shaping"))]
pub(super) fn refuse_shapes(c: &splineway_config) -> Result<(), splineway_result> {
    let none = c.shape.iter().all(|shape| shape.kind == 0);
    if none { Ok(()) } else { Err(splineway_result::CONFIG) }
}

/// By how much the setpoints are behind the program because they are shaped, s. Outputs in time with the path are behind with them:
/// `splineway_tick_outputs`. Of a library with the feature `shaping`.
///
/// Context: any.
#[cfg(feature = "shaping")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_shaper_delay(
    core: *mut splineway_core,
    seconds: *mut f32,
) -> splineway_result {
    let Some(core) = ready(core) else { return splineway_result::NOT_READY };
    if seconds.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the delay is set, and never changed; the caller gives a number to write to.
    unsafe { seconds.write((&raw const (*core).delay).read()) };
    splineway_result::OK
}
