//! The tables of Naseath 2007 as text: printed there, by its method here, by the bounded method.

use super::cases::{Family, RADII, ripple_peaks};
use super::comparison::{Comparison, MEASURES, METHODS, Measure, Tally, saved};
use super::printed::{CALCULATION, CORRELATIONS, LENGTH_OF_CASE_6, MEANS, NAMES};
use super::{Figures, Reading, Request, measure, smooth};
use anyhow::Result;
use splineway_splines::Trajectory;
use std::fmt::Write as _;

type Written = Result<(), std::fmt::Error>;

/// How a reading is called in a heading.
fn name(reading: Reading) -> &'static str {
    match reading {
        Reading::Free => "free",
        Reading::Middle => "middle",
        Reading::Edges => "edges",
    }
}

/// All tables, and how many of the printed figures come out.
///
/// # Errors
/// None, unless the cases themselves are wrong.
pub fn tables(comparison: &Comparison) -> Result<String> {
    let mut text = String::new();
    head(&mut text, comparison.readings)?;
    for k in [1, 2, 0, 3] {
        table(&mut text, comparison, &MEASURES[k])?;
    }
    calculation(&mut text, comparison)?;
    means(&mut text, comparison)?;
    correlations(&mut text, comparison)?;
    for family in [Family::OneHeight, Family::OneShape] {
        ripples(&mut text, family)?;
    }
    count(&mut text, comparison)?;
    Ok(text)
}

fn head(text: &mut String, readings: [Reading; 2]) -> Written {
    let [a, b] = readings.map(name);
    writeln!(
        text,
        "Naseath 2007: printed, by its method here, by the bounded method here. The cases are equivalents.\n\
         Where section 4.5 matters there are two readings of it:\n\
         free: greatest speeds lie anywhere between least ones, and what an S-curve does not need is run at them;\n\
         middle, edges: word by word; extremes stay, S-curves fill the distances, a plateau is one extreme (middle) or two\n\
         (edges). Here: {a} and {b}. Percentages are of improvement, as printed; ours are computed from all digits."
    )
}

/// Columns of our own figures: methods by readings, or methods alone.
fn columns(comparison: &Comparison, timed: bool) -> Vec<(usize, usize, String)> {
    let methods = ["as printed", "bounded"];
    let mut out = Vec::new();
    for (m, method) in methods.into_iter().enumerate() {
        for (r, reading) in comparison.readings.into_iter().enumerate() {
            if timed {
                out.push((m, r, format!("{method}, {}", name(reading))));
            } else if r == 0 {
                out.push((m, r, method.to_owned()));
            }
        }
    }
    out
}

fn table(text: &mut String, comparison: &Comparison, measure: &Measure) -> Written {
    let printed = &measure.table;
    let columns = columns(comparison, measure.timed);
    writeln!(text, "\nTable {}: {}", printed.number, printed.name)?;
    write!(text, "{:<12} {:>5} | {:>17}", "case", "R, mm", "printed")?;
    for (_, _, title) in &columns {
        write!(text, " | {title:>17}")?;
    }
    writeln!(text)?;
    let cell = |value: f64, percent: Option<f64>| {
        let digits = printed.digits;
        let percent = percent.map_or(String::new(), |percent| format!("{percent:.2}%"));
        (format!("{value:.digits$}"), percent)
    };
    for (k, case) in comparison.cases.iter().enumerate() {
        for state in 0..4usize {
            let label = match state {
                0 => format!("{}: {}", case.case.number, case.case.name),
                _ => String::new(),
            };
            let radius = state.checked_sub(1);
            let of = radius.map_or("given".to_owned(), |r| RADII[r].to_string());
            let (value, percent) =
                cell(printed.values[k][state], radius.map(|r| printed.improvement[k][r]));
            write!(text, "{label:<12} {of:>5} | {value:>8} {percent:>8}")?;
            for (m, r, _) in &columns {
                let given = &case.given[*r];
                let figures: &Figures = radius.map_or(given, |k| &case.runs[k][*m].figures[*r]);
                let percent = radius.map(|_| measure.improvement(given, figures));
                let (value, percent) = cell((measure.value)(figures), percent);
                write!(text, " | {value:>8} {percent:>8}")?;
            }
            writeln!(text)?;
        }
    }
    if printed.number == "4-3" {
        let [a, b, c] = LENGTH_OF_CASE_6;
        writeln!(
            text,
            "Case 6: tables 4-6 and 4-7 need {a}, {b} and {c} % here, not what table 4-3 prints."
        )?;
    }
    Ok(())
}

fn calculation(text: &mut String, comparison: &Comparison) -> Written {
    writeln!(
        text,
        "\nTable 4-5: calculation time, ms (printed: on a computer of 2007; here the least of several runs), and how \
         far the result is from the path as given, over R"
    )?;
    writeln!(
        text,
        "{:<12} {:>6} {:>5} | {:>8} | {:>10} {:>10} {:>6} | {:>10} {:>6} {:>10}",
        "case",
        "points",
        "R, mm",
        "printed",
        "as printed",
        "iterations",
        "off",
        "bounded",
        "off",
        "times that"
    )?;
    for (case, printed) in comparison.cases.iter().zip(CALCULATION) {
        for (k, (run, printed)) in case.runs.iter().zip(printed).enumerate() {
            let [own, bounded] = [0, 1].map(|m| run[m].smoothed.took.as_secs_f64() * 1e3);
            writeln!(
                text,
                "{:<12} {:>6} {:>5} | {:>8.0} | {own:>10.3} {:>10} {:>6.3} | {bounded:>10.3} {:>6.3} {:>10.1}",
                if k == 0 {
                    format!("{}: {}", case.case.number, case.case.name)
                } else {
                    String::new()
                },
                case.case.path.controls().len(),
                RADII[k],
                printed * 1e3,
                run[0].smoothed.iterations,
                run[0].off,
                run[1].off,
                bounded / own.max(1.0e-6),
            )?;
        }
    }
    Ok(())
}

fn means(text: &mut String, comparison: &Comparison) -> Written {
    writeln!(text, "\nTable 4-6: means of the improvements over the cases, per cent")?;
    write!(text, "{:<10} {:>7} | {:>8}", "", "R, mm", "printed")?;
    let columns = columns(comparison, true);
    for (_, _, title) in &columns {
        write!(text, " | {title:>17}")?;
    }
    writeln!(text)?;
    for ((measure, printed), name) in MEASURES.iter().zip(MEANS).zip(NAMES) {
        for (k, printed) in printed.into_iter().enumerate() {
            let of = k.checked_sub(1).map_or("overall".to_owned(), |r| RADII[r].to_string());
            write!(text, "{:<10} {of:>7} | {printed:>8.2}", if k == 0 { name } else { "" })?;
            for (m, r, _) in &columns {
                write!(text, " | {:>17.2}", comparison.means(measure, *m, *r)[k])?;
            }
            writeln!(text)?;
        }
    }
    Ok(())
}

fn correlations(text: &mut String, comparison: &Comparison) -> Written {
    writeln!(
        text,
        "\nTable 4-7: correlations of the improvements over cases and radii, and their P-values"
    )?;
    write!(text, "{:<30} | {:>17}", "", "printed")?;
    let columns = columns(comparison, true);
    for (_, _, title) in &columns {
        write!(text, " | {title:>17}")?;
    }
    writeln!(text)?;
    for printed in CORRELATIONS {
        let [a, b] = printed.pair.map(|k| NAMES[k]);
        let figure = printed.figure.map_or(String::new(), |figure| format!(" (figure {figure})"));
        write!(
            text,
            "{:<30} | {:>8.4} {:>8.4}",
            format!("{a}, {b}{figure}"),
            printed.coefficient,
            printed.probability
        )?;
        for (m, r, _) in &columns {
            let (coefficient, probability) = comparison.correlation(printed.pair, *m, *r);
            write!(text, " | {coefficient:>8.4} {probability:>8.4}")?;
        }
        writeln!(text)?;
    }
    Ok(())
}

fn ripples(text: &mut String, family: Family) -> Result<()> {
    let (trajectory, reading) = (Trajectory::thesis(), Reading::Free);
    let what = match family {
        Family::OneHeight => "of one height, steps shrink",
        Family::OneShape => "of one shape, height and steps shrink",
    };
    writeln!(
        text,
        "\nSingle ripples (section 3.12, figures 3-26 and 3-27), {what}: peak of curvature and time saved, per cent"
    )?;
    write!(text, "{:<10}", "peak, 1/mm")?;
    for title in ["as printed", "bounded"] {
        for radius in RADII {
            write!(text, " | {:>15}", format!("{title}, {radius}"))?;
        }
    }
    writeln!(text)?;
    for peak in ripple_peaks() {
        let path = family.ripple(peak)?;
        let given = measure(&path, &trajectory, reading);
        write!(text, "{peak:<10.4}")?;
        for method in METHODS {
            for radius in RADII {
                let smoothed = smooth(&path, &Request::new(method, radius))?;
                let figures = measure(&smoothed.path, &trajectory, reading);
                write!(
                    text,
                    " | {:>7.2} {:>7.2}",
                    saved(given.curvature_peak, figures.curvature_peak),
                    saved(given.time_s, figures.time_s)
                )?;
            }
        }
        writeln!(text)?;
    }
    Ok(())
}

fn count(text: &mut String, comparison: &Comparison) -> Written {
    let [a, b] = [0, 1].map(|reading| comparison.tally(reading));
    let of = |tally: Tally| {
        let [two, ten, quarter] = tally.within;
        format!("{two}, {ten}, {quarter}")
    };
    let [first, second] = comparison.readings.map(name);
    writeln!(
        text,
        "\nOf {} printed figures (tables 4-1 to 4-4, 4-6, 4-7) the thesis's method here is within 2, 10, 25 % of: \
         {first}: {}; {second}: {}",
        a.all,
        of(a),
        of(b)
    )
}
