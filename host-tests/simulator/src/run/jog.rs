//! Jogs in words, as they are typed and as they stand in files.

use crate::program::LETTERS;
use anyhow::{Context, Result, anyhow, bail, ensure};
use splineway::wire::JogMove;

/// A jog, by the word before and the words behind it; `None` if the word is none of a jog.
///
/// # Errors
/// What is not understood, or out of its range.
pub fn parse_jog(word: &str, words: &str) -> Result<Option<JogMove>> {
    let (joint, axes_wanted, example) = match word {
        "jog" => ("for", true, "X20 Y-5 for SECONDS"),
        "jog-step" => ("at", true, "X0.1 at FEED"),
        "jog-to" => ("at", true, "X0 Y0 at FEED"),
        "jog-back" => ("at", false, "at FEED"),
        _ => return Ok(None),
    };
    let (axes, last) = words
        .split_once(joint)
        .with_context(|| format!("\"{word}\" needs \"{joint}\" and a number, as in {example}"))?;
    let axes = parse_axes(axes)?;
    ensure!(
        axes.is_empty() != axes_wanted,
        "\"{words}\" is not what \"{word}\" takes, as in {example}"
    );
    let last = number(last.trim())?;
    let feed = || whole(last * 1.0e3, 1.0, f64::from(u32::MAX)).map(|feed| feed as u32);
    Ok(Some(match word {
        "jog" => {
            let range = (f64::from(i32::MIN), f64::from(i32::MAX));
            let micrometres = |mm: f64| Ok(whole(mm * 1.0e3, range.0, range.1)? as i32);
            let velocity = per_axis(axes, micrometres)?;
            let time = whole(last * 1.0e3, 1.0, 60_000.0)? as u16;
            JogMove::Velocity { velocity, time }
        }
        "jog-step" => JogMove::Step { by: per_axis(axes, nanometres)?, feed: feed()? },
        "jog-to" => {
            let to = per_axis(axes, |mm| nanometres(mm).map(Some))?;
            JogMove::To { to, feed: feed()? }
        }
        _ => JogMove::Back { feed: feed()? },
    }))
}

/// Letters with numbers.
pub(super) fn parse_axes(text: &str) -> Result<Vec<(usize, f64)>> {
    let mut axes = Vec::new();
    for word in text.split_whitespace() {
        let mut rest = word.chars();
        let letter = rest.next().map(|letter| letter.to_ascii_uppercase());
        let axis = LETTERS.iter().position(|axis| Some(*axis) == letter);
        let axis = axis.with_context(|| format!("\"{word}\" is no axis with a number"))?;
        ensure!(axes.iter().all(|(other, _)| *other != axis), "\"{word}\": the axis has a number");
        axes.push((axis, number(rest.as_str())?));
    }
    Ok(axes)
}

/// What the numbers of the axes stand for; of every other axis, nothing.
fn per_axis<T: Copy + Default>(
    axes: Vec<(usize, f64)>,
    of: impl Fn(f64) -> Result<T>,
) -> Result<[T; 9]> {
    let mut values = [T::default(); 9];
    for (axis, value) in axes {
        values[axis] = of(value)?;
    }
    Ok(values)
}

pub(super) fn number(text: &str) -> Result<f64> {
    let value: f64 = text.parse().map_err(|_| anyhow!("\"{text}\" is no number"))?;
    ensure!(value.is_finite(), "\"{text}\" is no number");
    Ok(value)
}

fn nanometres(mm: f64) -> Result<i64> {
    Ok(whole(mm * 1.0e6, -1.0e12, 1.0e12)? as i64)
}

/// Rounded, if it lies in a range.
fn whole(value: f64, least: f64, most: f64) -> Result<f64> {
    let whole = value.round();
    if !(whole >= least && whole <= most) {
        bail!("{value} in its smallest unit is out of the range {least} to {most}");
    }
    Ok(whole)
}

/// The same for a run in which not all axes are used: those that are, in order.
///
/// # Errors
/// The jog moves another.
pub fn on_axes(jog: &JogMove, axes: &[usize]) -> Result<JogMove> {
    Ok(match *jog {
        JogMove::Velocity { velocity, time } => {
            JogMove::Velocity { velocity: placed(&velocity, axes)?, time }
        }
        JogMove::Step { by, feed } => JogMove::Step { by: placed(&by, axes)?, feed },
        JogMove::To { to, feed } => JogMove::To { to: placed(&to, axes)?, feed },
        JogMove::Back { feed } => JogMove::Back { feed },
    })
}

/// What is asked of every axis, at the places of those that are used.
fn placed<T: Copy + Default + PartialEq>(asked: &[T; 9], axes: &[usize]) -> Result<[T; 9]> {
    let mut here = [T::default(); 9];
    for (axis, value) in asked.iter().enumerate().filter(|(_, value)| **value != T::default()) {
        let place = axes.iter().position(|&used| used == axis).with_context(|| {
            format!("the program does not use {}, so nor can a jog", LETTERS[axis])
        })?;
        here[place] = *value;
    }
    Ok(here)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jogs_are_words() {
        let jog = |word, words| parse_jog(word, words).unwrap().unwrap();
        let mut velocity = [0; 9];
        (velocity[0], velocity[1]) = (20_000, -5_000);
        assert_eq!(jog("jog", "X20 y-5 for 0.5"), JogMove::Velocity { velocity, time: 500 });
        let mut by = [0; 9];
        by[2] = 100_000;
        assert_eq!(jog("jog-step", "Z0.1 at 10"), JogMove::Step { by, feed: 10_000 });
        let mut to = [None; 9];
        (to[0], to[3]) = (Some(0), Some(-90_000_000));
        assert_eq!(jog("jog-to", "X0 A-90 at 5"), JogMove::To { to, feed: 5_000 });
        assert_eq!(jog("jog-back", "at 5"), JogMove::Back { feed: 5_000 });
        assert_eq!(parse_jog("hold", "").unwrap(), None);
        for (word, words) in [
            ("jog", "X20 Y-5"),
            ("jog", "for 1"),
            ("jog", "X1 X2 for 1"),
            ("jog", "X1 for 61"),
            ("jog", "Q1 for 1"),
            ("jog-step", "X at 1"),
            ("jog-to", "X1 at 0"),
            ("jog-to", "X1e9 at 1"),
            ("jog-back", "X1 at 5"),
        ] {
            assert!(parse_jog(word, words).is_err(), "{word} {words}");
        }
    }

    #[test]
    fn a_jog_is_of_the_axes_in_use() {
        let jog = parse_jog("jog-step", "X1 A2 at 3").unwrap().unwrap();
        let JogMove::Step { by, .. } = on_axes(&jog, &[0, 3]).unwrap() else { panic!() };
        assert_eq!(by[..3], [1_000_000, 2_000_000, 0]);
        assert!(on_axes(&jog, &[0, 1]).is_err());
    }
}
