//! Screen tiles with records of their content. A pass draws only the tiles that contain pixels of its object, or pixels to shade.

use std::sync::Arc;

use crate::constants::TILE_SIZE;
use leadr_gpu::{Buffer, Commands, Gpu, Memory, Result};

const SIZE: u32 = TILE_SIZE as u32;

/// The tiles of an image.
#[derive(Clone)]
pub struct Tiles {
    /// One `uvec4` per tile, row by row, with one bit for each object from 1 to 63 in xy, and flags in z.
    pub records: Buffer,
    columns: u32,
    rows: u32,
}

impl Tiles {
    /// Creates the tiles of an image of `size` pixels.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let (columns, rows) = (size.0.div_ceil(SIZE), size.1.div_ceil(SIZE));
        let bytes = u64::from(columns) * u64::from(rows) * 16;
        Ok(Self { records: Buffer::new(gpu, "tiles", bytes.max(16), Memory::Device)?, columns, rows })
    }

    /// Returns the numbers of tiles across and down.
    pub fn extent(&self) -> [u32; 2] {
        [self.columns, self.rows]
    }

    /// Draws the tiles within the scissor as points. The vertex shader of the bound pipeline selects tiles by their records.
    pub fn draw(&self, cmd: &mut Commands) {
        // The tiles at the right and at the bottom may extend beyond the image.
        cmd.viewport([0.0, 0.0, (self.columns * SIZE) as f32, (self.rows * SIZE) as f32]);
        cmd.draw(0..self.columns * self.rows, 0..1);
    }
}
