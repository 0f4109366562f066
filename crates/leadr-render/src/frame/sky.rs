//! The sky occlusion by large shapes, which is cached while the casters do not move.

use std::sync::Arc;

use crate::light::casters::Columns;
use crate::light::sky_visibility::{SkyProbe, SkyVisibility};
use crate::surfaces::posed::PosedObject;
use leadr_gpu::{Buffer, Gpu, Memory, Result};

/// The last visibility volume, and the shadow casters for which it was made.
#[derive(Default)]
pub struct SkyCache {
    last: Option<(Columns, SkyVisibility, Buffer)>,
}

impl SkyCache {
    /// Returns the buffer of the visibility volume around the shadow casters, or `None` without casters. The volume is made again
    /// when the casters have moved.
    pub fn around(&mut self, gpu: &Arc<Gpu>, casters: &[&PosedObject]) -> Result<Option<Buffer>> {
        let relief = casters.iter().map(|posed| posed.highest_bump()).fold(0.0, f32::max);
        let triangles = casters.iter().flat_map(|posed| posed.triangles());
        let Some(columns) = Columns::of(triangles, relief) else { return Ok(None) };
        if let Some((known, _, buffer)) = &self.last
            && *known == columns
        {
            return Ok(Some(buffer.clone()));
        }
        let volume = SkyVisibility::around(&columns);
        let bytes = volume.bytes();
        let buffer = Buffer::new(gpu, "sky visibility", bytes.len() as u64, Memory::Upload)?;
        buffer.write(0, &bytes)?;
        self.last = Some((columns, volume, buffer.clone()));
        Ok(Some(buffer))
    }

    /// Returns the probes of the last visibility volume.
    pub fn probes(&self) -> Vec<SkyProbe> {
        self.last.iter().flat_map(|(_, volume, _)| volume.probes()).collect()
    }
}
