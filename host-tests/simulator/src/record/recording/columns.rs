//! Numbers as bytes, a column for each kind: what compresses well.

/// A column of whole numbers, seven bits a byte.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Column {
    bytes: Vec<u8>,
    zeros: usize,
}

impl From<Vec<u8>> for Column {
    /// What [`Column::bytes`] gave.
    fn from(bytes: Vec<u8>) -> Self {
        Self { bytes, zeros: 0 }
    }
}

impl Column {
    /// One more number that is not negative.
    pub fn count(&mut self, mut x: u64) {
        self.zeros += usize::from(x == 0);
        while x >= 0x80 {
            self.bytes.push(x as u8 | 0x80);
            x >>= 7;
        }
        self.bytes.push(x as u8);
    }

    /// One more number of either sign.
    pub fn number(&mut self, x: i64) {
        self.count((x << 1 ^ x >> 63).cast_unsigned());
    }

    /// The bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Bytes that are left by compression, about, of numbers that were added here: axes at rest are next to nothing.
    pub const fn weight(&self) -> usize {
        self.bytes.len() - self.zeros + self.zeros / 16
    }

    /// Reads from the beginning.
    pub fn read(&self) -> Numbers<'_> {
        Numbers { bytes: &self.bytes }
    }
}

/// What is left of a column.
#[derive(Clone, Copy, Debug)]
pub struct Numbers<'a> {
    bytes: &'a [u8],
}

impl<'a> Numbers<'a> {
    /// Of bytes that a column had.
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    /// The next number that is not negative; 0 if none is left.
    pub fn count(&mut self) -> u64 {
        let mut x = 0;
        let mut shift = 0;
        while let Some((byte, rest)) = self.bytes.split_first() {
            self.bytes = rest;
            x |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if *byte < 0x80 || shift > 63 {
                break;
            }
        }
        x
    }

    /// The next number of either sign.
    pub fn number(&mut self) -> i64 {
        let x = self.count();
        (x >> 1).cast_signed() ^ -(x & 1).cast_signed()
    }

    /// Whether nothing is left.
    pub const fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back() {
        let numbers = [0, -1, 1, 63, 64, -64, -65, 1 << 40, i64::MAX, i64::MIN];
        let mut column = Column::default();
        for x in numbers {
            column.number(x);
        }
        assert_eq!(column.bytes()[..4], [0, 1, 2, 126]);
        let mut read = column.read();
        assert!(numbers.iter().all(|x| read.number() == *x) && read.is_empty());
        assert_eq!(read.count(), 0);
    }
}
