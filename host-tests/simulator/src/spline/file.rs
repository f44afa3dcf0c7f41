//! Spline files: JSON, TOML, or text.
//!
//! JSON and TOML have the members of [`SplineFile`]. A text file has one item per line: `point X Y
//! [Z]`, `knots K ...` (or, for a closed spline, `intervals`), `tolerance R`, `precision N`, `accuracy
//! A`, `feed F`, `closed`; `#` begins a comment.

use super::nurbs::Nurbs;
use super::path::Path;
use anyhow::{Context, Result, anyhow, bail, ensure};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path as FilePath;

/// Greatest distance between a NURBS curve and the spline that stands for it, mm.
const CONVERSION_ERROR: f64 = 1.0e-5;

/// A spline as it stands in a file.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct SplineFile {
    /// What it is called.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// 3 if left out; other degrees are converted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degree: Option<usize>,
    /// Two or three coordinates each, mm.
    pub control_points: Vec<Vec<f64>>,
    /// Of a rational curve, which is converted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<Vec<f64>>,
    /// Each once, threefold or fourfold at the ends; of a closed spline its intervals.
    pub knots: Vec<f64>,
    /// Whether it is closed.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub closed: bool,
    /// Radius of the tube, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Places per knot interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub precision: Option<u32>,
    /// Share of the radius.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<f64>,
    /// Feed, mm/s, when it is run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feed: Option<f64>,
    /// What else there is, and is not looked at.
    #[serde(flatten, skip_serializing)]
    pub other: BTreeMap<String, serde_json::Value>,
}

/// Whether a text file holds a spline, and not points of a poly-line.
pub fn is_spline(text: &str) -> bool {
    text.lines().any(|line| line.trim_start().starts_with("point "))
}

fn numbers(words: &[&str], line: usize) -> Result<Vec<f64>> {
    words
        .iter()
        .map(|word| {
            let x: f64 = word.parse().map_err(|_| anyhow!("line {line}: '{word}' is no number"))?;
            ensure!(x.is_finite(), "line {line}: {word} is not finite");
            Ok(x)
        })
        .collect()
}

fn parse_text(text: &str) -> Result<SplineFile> {
    let mut file = SplineFile::default();
    for (n, line) in text.lines().enumerate() {
        let n = n + 1;
        let words: Vec<&str> = line.split('#').next().unwrap_or("").split_whitespace().collect();
        let Some((item, rest)) = words.split_first() else { continue };
        let one = || -> Result<f64> {
            ensure!(rest.len() == 1, "line {n}: '{item}' takes one number");
            Ok(numbers(rest, n)?[0])
        };
        match *item {
            "point" => file.control_points.push(numbers(rest, n)?),
            "knots" | "intervals" => file.knots.extend(numbers(rest, n)?),
            "tolerance" => file.tolerance = Some(one()?),
            "accuracy" => file.accuracy = Some(one()?),
            "feed" => file.feed = Some(one()?),
            "precision" => {
                let x = one()?;
                ensure!(x >= 1.0 && x.fract() == 0.0, "line {n}: precision {x} is no count");
                file.precision = Some(x as u32);
            }
            "closed" => file.closed = true,
            _ => bail!(
                "line {n}: '{item}' is none of point, knots, intervals, tolerance, precision, \
                 accuracy, feed, closed"
            ),
        }
    }
    Ok(file)
}

impl SplineFile {
    /// Takes the text of a file; the kind is told by its ending.
    ///
    /// # Errors
    /// Names the place in the text and what is wrong there.
    pub fn parse(text: &str, ending: &str) -> Result<Self> {
        let file: Self = match ending {
            "json" => serde_json::from_str(text).context("not a spline")?,
            "toml" => toml::from_str(text).context("not a spline")?,
            "txt" => parse_text(text)?,
            _ => bail!("a spline file is .json, .toml or .txt"),
        };
        file.check()?;
        Ok(file)
    }

    /// What is wrong whatever the file is for.
    fn check(&self) -> Result<()> {
        for (what, value) in [("tolerance", self.tolerance), ("feed", self.feed)] {
            if let Some(x) = value {
                ensure!(x > 0.0 && x.is_finite(), "{what} is {x}; it must be greater than 0");
            }
        }
        if let Some(units) = self.other.get("units") {
            ensure!(units == "mm", "units are {units}; coordinates must be in mm");
        }
        Ok(())
    }

    /// Members that are there and stand for nothing here, but for words about the file.
    pub fn unused(&self) -> Vec<&str> {
        let names = self.other.keys().map(String::as_str);
        names.filter(|name| !["comment", "description", "source", "units"].contains(name)).collect()
    }

    /// The curve by all its knots, which may be there more than once: of another degree, rational, or a cubic that is written so.
    ///
    /// # Errors
    /// As [`SplineFile::nurbs`].
    pub fn by_all_knots(&self) -> Result<Option<Nurbs>> {
        let all = self.knots.len() == self.control_points.len() + 4;
        if self.degree == Some(3) && self.weights.is_none() && all && !self.closed {
            return self.as_nurbs().map(Some);
        }
        self.nurbs()
    }

    fn as_nurbs(&self) -> Result<Nurbs> {
        let (points, weights) = (self.control_points.clone(), self.weights.clone());
        Nurbs::new(self.degree.unwrap_or(3), points, weights, self.knots.clone())
    }

    /// The curve that it is if it is none of the cubic splines of this program: of another degree, or
    /// rational.
    ///
    /// # Errors
    /// Names the control point, knot or weight that is wrong.
    pub fn nurbs(&self) -> Result<Option<Nurbs>> {
        if self.degree.unwrap_or(3) == 3 && self.weights.is_none() {
            return Ok(None);
        }
        ensure!(!self.closed, "a closed spline must be cubic and without weights");
        self.as_nurbs().map(Some)
    }

    /// The spline; curves of another degree, or rational ones, are converted.
    ///
    /// # Errors
    /// Names the control point, knot or weight that is wrong.
    pub fn path(&self) -> Result<Path> {
        for (i, point) in self.control_points.iter().enumerate() {
            ensure!(
                (2..=3).contains(&point.len()),
                "control point {i} has {} coordinates; two or three are expected",
                point.len()
            );
        }
        if let Some(curve) = self.nurbs()? {
            return curve.spline(CONVERSION_ERROR);
        }
        let points: Vec<[f64; 3]> = self
            .control_points
            .iter()
            .map(|p| [p[0], p[1], p.get(2).copied().unwrap_or(0.0)])
            .collect();
        Ok(if self.closed {
            Path::closed(&points, &self.knots)?
        } else {
            Path::open(&points, &self.knots)?
        })
    }

    /// What stands for a path in a file.
    pub fn of(path: &Path) -> Self {
        let flat = path.controls().iter().all(|p| p[2] == 0.0);
        let count = if flat { 2 } else { 3 };
        Self {
            control_points: path.controls().iter().map(|p| p[..count].to_vec()).collect(),
            knots: path.printed_knots().collect(),
            closed: path.is_closed(),
            ..Self::default()
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        let join =
            |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        if self.closed {
            text.push_str("closed\n");
        }
        if let Some(tolerance) = self.tolerance {
            let _ = writeln!(text, "tolerance {tolerance}");
        }
        let word = if self.closed { "intervals" } else { "knots" };
        let _ = writeln!(text, "{word} {}", join(&self.knots));
        for point in &self.control_points {
            let _ = writeln!(text, "point {}", join(point));
        }
        text
    }
}

fn ending(path: &FilePath) -> &str {
    path.extension().and_then(|ending| ending.to_str()).unwrap_or("")
}

/// Writes a spline file.
///
/// # Errors
/// An unknown ending, or a file that cannot be written.
pub fn write(path: &FilePath, file: &SplineFile) -> Result<()> {
    let text = match ending(path) {
        "json" => serde_json::to_string_pretty(file)?,
        "toml" => toml::to_string(file)?,
        "txt" => file.text(),
        _ => bail!("{}: a spline file is .json, .toml or .txt", path.display()),
    };
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# a wave\ntolerance 0.25\nprecision 5\nknots 0 0 0 2 3 5 5 5\n\
        point 0 0\npoint 1 2\npoint 3 1.5\npoint 4 -1\npoint 6 0.5\npoint 7.5 0\n";

    #[test]
    fn the_three_kinds_hold_the_same() {
        let file = SplineFile::parse(TEXT, "txt").unwrap();
        assert_eq!((file.tolerance, file.precision), (Some(0.25), Some(5)));
        let path = file.path().unwrap();
        let again = SplineFile::of(&path);
        for (text, ending) in [
            (serde_json::to_string(&again).unwrap(), "json"),
            (toml::to_string(&again).unwrap(), "toml"),
            (again.text(), "txt"),
        ] {
            let other = SplineFile::parse(&text, ending).unwrap().path().unwrap();
            assert_eq!(other.at(2.5).map(f64::to_bits), path.at(2.5).map(f64::to_bits));
        }
    }

    #[test]
    fn errors_name_the_place() {
        for (text, ending, part) in [
            ("point 0 x\n", "txt", "line 1: 'x'"),
            ("\nwobble 3\n", "txt", "line 2: 'wobble'"),
            ("tolerance\n", "txt", "line 1: 'tolerance' takes one"),
            ("{\"knots\": 3}", "json", "line 1 column"),
            ("knots = [0]\ncontrol_points = 7\n", "toml", "line 2"),
        ] {
            let error = format!("{:#}", SplineFile::parse(text, ending).unwrap_err());
            assert!(error.contains(part), "{error}");
        }
        let error = SplineFile::parse("point 0 0\npoint 1\nknots 0 1\n", "txt")
            .unwrap()
            .path()
            .unwrap_err();
        assert!(error.to_string().contains("control point 1 has 1 coordinates"), "{error}");
    }
}
