//! Splitting a line into words.

use anyhow::{Result, bail};

/// A letter and its number, and where they stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word {
    /// Upper-case letter.
    pub letter: char,
    /// Number behind it.
    pub value: f64,
    /// Column of the letter, from 1.
    pub column: usize,
}

/// The words of a line, without comments, block delete and program marks.
///
/// # Errors
/// Names column and reason.
pub fn split(line: &str) -> Result<Vec<Word>> {
    let bytes = line.as_bytes();
    let mut words = Vec::new();
    let mut i = 0;
    while let Some(&byte) = bytes.get(i) {
        match byte {
            // Comments, program marks, and the checksum of a serial protocol.
            b';' | b'%' | b'*' => break,
            b'(' => match line[i..].find(')') {
                Some(length) => i += length + 1,
                None => bail!("column {}: the comment is not closed", i + 1),
            },
            b' ' | b'\t' | b'\r' | b'/' => i += 1,
            b'a'..=b'z' | b'A'..=b'Z' => {
                let column = i + 1;
                let letter = byte.to_ascii_uppercase() as char;
                i += 1;
                while bytes.get(i).is_some_and(|b| matches!(b, b' ' | b'\t')) {
                    i += 1;
                }
                let start = i;
                while bytes.get(i).is_some_and(|b| matches!(b, b'0'..=b'9' | b'.' | b'+' | b'-')) {
                    i += 1;
                }
                let text = &line[start..i];
                let Ok(value) = text.parse::<f64>() else {
                    let found = line[start..].chars().next();
                    match found {
                        _ if !text.is_empty() => {
                            bail!("column {column}: \"{letter}{text}\" is not a number")
                        }
                        Some(c @ ('#' | '[')) => {
                            bail!(
                                "column {column}: parameters and expressions (\"{c}\") are not supported"
                            )
                        }
                        _ => bail!("column {column}: no number behind \"{letter}\""),
                    }
                };
                words.push(Word { letter, value, column });
            }
            b'#' => bail!("column {}: parameters are not supported", i + 1),
            _ => {
                let character = line[i..].chars().next().unwrap_or('?');
                bail!("column {}: unexpected character \"{character}\"", i + 1)
            }
        }
    }
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_comments_and_spaces() {
        let words = split("/n10 g1(to the right)X-.5 y 2. ; end").unwrap();
        let plain: Vec<(char, f64)> = words.iter().map(|word| (word.letter, word.value)).collect();
        assert_eq!(plain, [('N', 10.0), ('G', 1.0), ('X', -0.5), ('Y', 2.0)]);
        assert_eq!(words[2].column, 22);
    }

    #[test]
    fn errors_name_the_column() {
        for (line, message) in [
            ("G1 X", "column 4: no number behind \"X\""),
            ("G1 X1.2.3", "column 4: \"X1.2.3\" is not a number"),
            ("G1 (open", "column 4: the comment is not closed"),
            ("G1 X#1", "column 4: parameters and expressions (\"#\") are not supported"),
            ("G1 X1 !", "column 7: unexpected character \"!\""),
        ] {
            assert_eq!(split(line).unwrap_err().to_string(), message);
        }
    }
}
