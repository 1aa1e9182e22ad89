//! Numbers that are owned, or lie in bytes that someone else holds: a file read or mapped once and used where it is.

use std::borrow::Cow;
use std::fmt;
use std::ops::{Deref, Range};
use std::sync::Arc;

use bytemuck::{AnyBitPattern, NoUninit};

/// Bytes that columns lie in.
pub type SharedBytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// A row of numbers; never changed.
#[derive(Clone)]
pub struct Column<T>(Source<T>);

#[derive(Clone)]
enum Source<T> {
    Owned(Arc<Vec<T>>),
    Shared { bytes: SharedBytes, range: Range<usize> },
}

impl<T: AnyBitPattern> Column<T> {
    /// The numbers in a range of bytes, little-endian, where they are. `None` if the range is not within the bytes, holds no
    /// whole number of them, or lies where they can't be read; on a big-endian machine only bytes can be.
    pub fn shared(bytes: SharedBytes, range: Range<usize>) -> Option<Column<T>> {
        let is_readable = cfg!(target_endian = "little") || size_of::<T>() == 1;
        let slice = (*bytes).as_ref().get(range.clone()).filter(|_| is_readable)?;
        bytemuck::try_cast_slice::<u8, T>(slice).ok()?;
        Some(Column(Source::Shared { bytes, range }))
    }
}

impl<T> Column<T> {
    /// Memory that the numbers take, owned or not.
    pub fn bytes(&self) -> usize {
        match &self.0 {
            Source::Owned(numbers) => size_of_val(&numbers[..]),
            Source::Shared { range, .. } => range.len(),
        }
    }

    /// Whether the numbers lie in bytes that someone else holds.
    pub fn is_shared(&self) -> bool {
        matches!(self.0, Source::Shared { .. })
    }
}

impl<T: AnyBitPattern> Deref for Column<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match &self.0 {
            Source::Owned(numbers) => numbers,
            // it was tried when the column was made, and the bytes can't change behind a shared reference
            Source::Shared { bytes, range } => bytemuck::cast_slice(&(**bytes).as_ref()[range.clone()]),
        }
    }
}

impl<T: AnyBitPattern + NoUninit> Column<T> {
    /// The numbers, little-endian.
    pub fn le_bytes(&self) -> Cow<'_, [u8]> {
        if cfg!(target_endian = "little") || size_of::<T>() == 1 {
            return Cow::Borrowed(bytemuck::cast_slice(self));
        }
        let numbers = bytemuck::cast_slice::<T, u8>(self).chunks_exact(size_of::<T>());
        Cow::Owned(numbers.flat_map(|number| number.iter().rev()).copied().collect())
    }

    /// The numbers in little-endian bytes, copied. `None` if it is no whole number of them.
    pub fn copied(bytes: &[u8]) -> Option<Column<T>> {
        let numbers = bytes.chunks_exact(size_of::<T>());
        if !numbers.remainder().is_empty() {
            return None;
        }
        let number = |bytes: &[u8]| {
            if cfg!(target_endian = "little") {
                return bytemuck::pod_read_unaligned(bytes);
            }
            let reversed: Vec<u8> = bytes.iter().rev().copied().collect();
            bytemuck::pod_read_unaligned(&reversed)
        };
        Some(numbers.map(number).collect::<Vec<T>>().into())
    }
}

impl<T> From<Vec<T>> for Column<T> {
    fn from(numbers: Vec<T>) -> Column<T> {
        Column(Source::Owned(Arc::new(numbers)))
    }
}

impl<T: AnyBitPattern + PartialEq> PartialEq for Column<T> {
    fn eq(&self, other: &Column<T>) -> bool {
        **self == **other
    }
}

impl<T> fmt::Debug for Column<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Column of {} bytes", self.bytes())
    }
}
