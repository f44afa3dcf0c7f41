//! Poly-line paths: `# vmax amax jmax tol cycle`, then `x y z feed` per vertex.

use super::{Course, Header, Move, Program, Speed};
use anyhow::{Result, anyhow, bail};

/// Reads a poly-line. The first vertex is where the motion starts.
///
/// # Errors
/// Names line, column and reason.
pub fn parse(text: &str) -> Result<Program> {
    let mut program = Program::default();
    let mut started = false;
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        let content = line.trim();
        if content.is_empty() {
            continue;
        }
        if let Some(header) = content.strip_prefix('#') {
            if index > 0 {
                // What looks like one and is a comment leaves the machine at other limits than its author thinks.
                if numbers::<5>(line, header, number).is_ok() {
                    bail!("line {number}: a header (#, five numbers) must be line 1");
                }
            } else {
                let [velocity, acceleration, jerk, tolerance, cycle] =
                    numbers(line, header, number)?;
                program.header = Some(Header { velocity, acceleration, jerk, tolerance, cycle });
            }
            continue;
        }
        let [x, y, z, feed] = numbers(line, content, number)?;
        let mut to = [0.0; 9];
        to[..3].copy_from_slice(&[x, y, z]);
        if !started {
            started = true;
            program.start = to;
            program.uses[..3].fill(true);
            continue;
        }
        if !(feed > 0.0) {
            bail!("line {number}: feed is {feed} mm/s; it must be greater than 0");
        }
        let line = u32::try_from(number)?;
        program.moves.push(Move::new(Course::Line { to }, Speed::PerSecond(feed), line));
    }
    if !started {
        bail!("line 1: the file has no vertex (a line of x y z feed)");
    }
    Ok(program)
}

/// Exactly `N` finite numbers.
fn numbers<const N: usize>(line: &str, content: &str, number: usize) -> Result<[f64; N]> {
    let mut values = [0.0; N];
    let mut count = 0;
    for word in content.split_whitespace() {
        let column = word.as_ptr() as usize - line.as_ptr() as usize + 1;
        let value: f64 = word
            .parse()
            .map_err(|_| anyhow!("line {number}, column {column}: \"{word}\" is not a number"))?;
        if !value.is_finite() {
            bail!("line {number}, column {column}: \"{word}\" is not finite");
        }
        if let Some(slot) = values.get_mut(count) {
            *slot = value;
        }
        count += 1;
    }
    if count != N {
        bail!("line {number}: {count} numbers where {N} are expected");
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_and_vertices() {
        let program = parse("# 200 2000 50000 0.05 0.001\n0 0 0 200\n\n1 2 3 100\n").unwrap();
        assert_eq!(program.moves.len(), 1);
        assert_eq!(program.moves[0].line, 4);
        assert!((program.header.unwrap().tolerance - 0.05).abs() < 1e-15);
    }

    #[test]
    fn errors_name_line_and_column() {
        let error = parse("# 1 1 1 1 1\n0 0 0 1\n 1 two 3 4\n").unwrap_err().to_string();
        assert_eq!(error, "line 3, column 4: \"two\" is not a number");
        for text in ["0 0 0 1\n# 1 1 1 1 1\n1 0 0 1\n", "\n# 1 1 1 1 1\n0 0 0 1\n"] {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.contains("line 2: a header"), "{error}");
        }
        assert!(parse("0 0 0 1\n# five more: 1 1 1 1 1\n1 0 0 1\n").is_ok());
        assert!(parse("").is_err());
        assert!(parse("0 0 0 1\n1 1 1 0\n").unwrap_err().to_string().contains("feed is 0"));
    }
}
