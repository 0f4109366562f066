//! A reader for little-endian numbers.

use leadr_maps::MapFault;

/// A reader that takes numbers from the front of the remaining bytes.
pub struct Bytes<'a> {
    left: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub const fn new(left: &'a [u8]) -> Self {
        Self { left }
    }

    pub fn take(&mut self, count: usize) -> Result<&'a [u8], MapFault> {
        let (taken, left) =
            self.left.split_at_checked(count).ok_or_else(|| MapFault::damaged("it ends early (truncated?)"))?;
        self.left = left;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], MapFault> {
        Ok(self.take(N)?.try_into().expect("as many bytes were taken"))
    }

    pub fn u8(&mut self) -> Result<u8, MapFault> {
        Ok(self.array::<1>()?[0])
    }

    pub fn u16(&mut self) -> Result<u16, MapFault> {
        self.array().map(u16::from_le_bytes)
    }

    pub fn u32(&mut self) -> Result<u32, MapFault> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Result<u64, MapFault> {
        self.array().map(u64::from_le_bytes)
    }
}

/// Returns the consecutive doubles in `bytes`.
pub fn doubles(bytes: &[u8]) -> impl Iterator<Item = f64> + '_ {
    bytes.as_chunks().0.iter().map(|chunk| f64::from_le_bytes(*chunk))
}
