//! Decimal numbers, without the standard library's long way and its panics.

/// Powers of ten that an `f64` holds exactly.
const POWERS: [f64; 23] = [
    1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];
/// Exponents beyond this are infinite or zero whatever stands before them.
const FAR: i32 = 400;

/// A number as it is read, digit by digit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Decimal {
    mantissa: u64,
    /// Of ten.
    exponent: i32,
    /// Whether there was any digit.
    pub digits: bool,
    /// Whether there was a point.
    pub point: bool,
    pub negative: bool,
}

impl Decimal {
    /// A further digit, 0 to 9.
    pub fn digit(&mut self, digit: u8) {
        self.digits = true;
        // Nineteen digits fit; what comes behind them is less than a double can tell.
        if self.mantissa < 1_000_000_000_000_000_000 {
            self.mantissa = self.mantissa * 10 + u64::from(digit);
            if self.point {
                self.exponent = self.exponent.saturating_sub(1);
            }
        } else if !self.point {
            self.exponent = self.exponent.saturating_add(1);
        }
    }

    /// The exponent that was written.
    pub fn shift(&mut self, exponent: i32) {
        self.exponent = self.exponent.saturating_add(exponent);
    }

    /// The value: the nearest double where the digits are up to fifteen and the exponent up to 22 (every number of
    /// a program), else at most the next but one. Infinite if it is too large for one.
    ///
    /// Costs one division; 20 multiplications at most for a large exponent.
    pub fn value(&self) -> f64 {
        let mut value = self.mantissa as f64;
        let mut left = self.exponent.clamp(-FAR, FAR);
        while left != 0 && value != 0.0 {
            let step = left.clamp(-22, 22);
            let power = POWERS.get(step.unsigned_abs() as usize).copied().unwrap_or(1.0);
            value = if step < 0 { value / power } else { value * power };
            left -= step;
        }
        if self.negative { -value } else { value }
    }
}

/// The number that a text begins with, without an exponent, and what is behind it.
#[cfg(feature = "grbl")]
pub fn parse(text: &[u8]) -> Option<(f64, &[u8])> {
    let mut number = Decimal::default();
    let mut rest = text;
    if let [sign @ (b'+' | b'-'), behind @ ..] = text {
        (number.negative, rest) = (*sign == b'-', behind);
    }
    while let [byte, behind @ ..] = rest {
        match byte {
            b'0'..=b'9' => number.digit(byte - b'0'),
            b'.' if !number.point => number.point = true,
            _ => break,
        }
        rest = behind;
    }
    number.digits.then(|| (number.value(), rest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;
    use std::string::String;

    fn read(text: &str) -> f64 {
        let mut number = Decimal::default();
        for byte in text.bytes() {
            match byte {
                b'-' => number.negative = true,
                b'.' => number.point = true,
                digit => number.digit(digit - b'0'),
            }
        }
        number.value()
    }

    #[test]
    fn numbers_of_programs_are_the_nearest_doubles() {
        for text in [
            "0",
            "-0.0001",
            "43.9090",
            "25.4",
            "123456789.123456",
            ".5",
            "5.",
            "0.1",
            "999999.999999",
        ] {
            let expected: f64 = text.parse().unwrap();
            assert_eq!(read(text).to_bits(), expected.to_bits(), "{text}");
        }
        let mut seed = 1u64;
        for _ in 0..100_000 {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let (whole, part) = (seed >> 44, (seed >> 20) % 1_000_000);
            let text = format!("{whole}.{part:06}");
            assert_eq!(read(&text).to_bits(), text.parse::<f64>().unwrap().to_bits(), "{text}");
        }
    }

    #[test]
    fn long_numbers_are_close() {
        for text in [
            "3.141592653589793238462643383279",
            "12345678901234567890123",
            "0.00000000000000000000000001234567",
        ] {
            let expected: f64 = text.parse().unwrap();
            assert!((read(text) / expected - 1.0).abs() < 5e-16, "{text}");
        }
        assert!(read(&String::from_iter(["9"; 500])).is_infinite());
        let mut small = Decimal::default();
        small.digit(1);
        small.shift(-10_000);
        assert_eq!(small.value().to_bits(), 0);
    }
}
