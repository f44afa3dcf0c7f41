//! An option in memory that is all zeros while there is nothing in it.

use heapless::Vec;

/// As an `Option`, which stands for nothing by any pattern that no value has: a `static` would not be all zeros, and
/// take its size in the image and a copy at start-up.
#[derive(Clone, Debug)]
pub struct Optional<T>(Vec<T, 1>);

impl<T> Optional<T> {
    pub const NONE: Self = Self(Vec::new());

    pub fn is_some(&self) -> bool {
        !self.0.is_empty()
    }

    pub fn as_ref(&self) -> Option<&T> {
        self.0.first()
    }

    pub fn as_mut(&mut self) -> Option<&mut T> {
        self.0.first_mut()
    }

    pub fn take(&mut self) -> Option<T> {
        self.0.pop()
    }

    pub fn set(&mut self, value: Option<T>) {
        self.0.clear();
        if let Some(value) = value {
            // There is room for one.
            let _ = self.0.push(value);
        }
    }
}
