//! Animated WebP, lossless. The pictures are encoded by `image-webp`; the container about them, which that crate does not
//! write, is here ([specification](https://developers.google.com/speed/webp/docs/riff_container)).

use std::fs::File;
use std::io::{Seek, SeekFrom, Write};

use image_webp::{ColorType, WebPEncoder};

use super::animation::{Change, Encoder, Header};

/// Writes a RIFF file, whose length is filled in at the end.
pub struct Webp {
    file: File,
    length: u64,
}

/// Bytes in front of the first chunk: `RIFF`, a length, `WEBP`.
const RIFF_HEADER: usize = 12;

/// In the flags of the file: there are frames.
const ANIMATION: u8 = 1 << 1;

/// In the flags of a frame: it replaces what was there.
const NO_BLENDING: u8 = 1 << 1;

impl Webp {
    fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.length += bytes.len() as u64;
        // The length in the header does not count itself and what is before it.
        if self.length - 8 > u64::from(u32::MAX) {
            return Err("a WebP has at most 4 GiB; write fewer or smaller frames".to_owned());
        }
        self.file.write_all(bytes).map_err(|e| e.to_string())
    }
}

/// A chunk: its name, its length, its contents, and a byte if that is odd.
fn chunk(name: &[u8; 4], contents: &[u8]) -> Vec<u8> {
    let mut bytes = [name, &(contents.len() as u32).to_le_bytes()[..], contents].concat();
    bytes.resize(bytes.len().next_multiple_of(2), 0);
    bytes
}

/// The low three bytes of a number.
fn three(number: u64) -> [u8; 3] {
    let [a, b, c, ..] = number.to_le_bytes();
    [a, b, c]
}

impl Encoder for Webp {
    fn begin(file: File, header: &Header) -> Result<Self, String> {
        let mut webp = Self { file, length: 0 };
        let (width, height) = (header.size.width, header.size.height);
        let flags = [ANIMATION, 0, 0, 0];
        let canvas = [three(u64::from(width) - 1), three(u64::from(height) - 1)];
        let background = [0, 0, 0, 0xff];
        webp.write(b"RIFF\0\0\0\0WEBP")?;
        webp.write(&chunk(b"VP8X", &[&flags[..], canvas.as_flattened()].concat()))?;
        webp.write(&chunk(b"ANIM", &[&background[..], &header.plays.to_le_bytes()].concat()))?;
        Ok(webp)
    }

    fn units(_: &Header) -> u32 {
        1000
    }

    fn put(&mut self, change: &Change, delay: u64) -> Result<(), String> {
        // Corners are stored halved.
        let area = change.area(2);
        let mut still = Vec::new();
        let encoder = WebPEncoder::new(&mut still);
        encoder.encode(&change.rgb(area), area.width, area.height, ColorType::Rgb8).map_err(|e| e.to_string())?;
        let picture = still.get(RIFF_HEADER..).filter(|rest| rest.starts_with(b"VP8L"));
        let picture = picture.ok_or("the encoder of WebP returned no lossless picture")?;
        let numbers = [area.x / 2, area.y / 2, area.width - 1, area.height - 1].map(|n| three(n.into()));
        let frame = [numbers.as_flattened(), &three(delay), &[NO_BLENDING], picture].concat();
        self.write(&chunk(b"ANMF", &frame))
    }

    fn finish(mut self) -> Result<(), String> {
        let length = (self.length - 8) as u32;
        let mut fill_in = || {
            self.file.seek(SeekFrom::Start(4))?;
            self.file.write_all(&length.to_le_bytes())
        };
        fill_in().map_err(|e| e.to_string())
    }
}
