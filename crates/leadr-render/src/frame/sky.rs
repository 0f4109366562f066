//! What large shapes hide of the surroundings, kept while they stay.

use std::cell::Cell;
use std::sync::Arc;

use crate::constants::{SKY_HEADER, SKY_NODES};
use crate::light::casters::Columns;
use crate::light::irradiance::IrradiancePass;
use crate::light::sky_visibility::{SkyProbe, SkyVisibility};
use crate::surfaces::posed::PosedObject;
use leadr_gpu::{Buffer, Commands, Gpu, Memory, Result};

/// A volume as a frame hands it to the device.
pub struct SkyBuffer {
    words: Buffer,
    volume: SkyVisibility,
    /// Its number, which tells it from others.
    number: u64,
}

/// The last volume that was made, and the one that the device has.
#[derive(Default)]
pub struct SkyPast {
    last: Option<(Columns, Arc<SkyBuffer>)>,
    made: u64,
    recorded: Cell<Option<u64>>,
}

impl SkyPast {
    /// The volume about what throws shadows; `None` without any. It is made anew where that has moved.
    pub fn around(&mut self, gpu: &Arc<Gpu>, casters: &[&PosedObject]) -> Result<Option<Arc<SkyBuffer>>> {
        let Some(columns) = Columns::of(casters.iter().flat_map(|posed| posed.triangles())) else { return Ok(None) };
        if let Some((known, sky)) = &self.last
            && *known == columns
        {
            return Ok(Some(sky.clone()));
        }
        let volume = SkyVisibility::around(&columns);
        let size = 4 * u64::from(SKY_HEADER + SKY_NODES);
        let buffer = Buffer::new(gpu, "sky visibility", size, Memory::Upload)?;
        buffer.write(0, &volume.words())?;
        self.made += 1;
        let sky = Arc::new(SkyBuffer { words: buffer, volume, number: self.made });
        self.last = Some((columns, sky.clone()));
        Ok(Some(sky))
    }

    /// The nodes of the last volume.
    pub fn probes(&self) -> Vec<SkyProbe> {
        self.last.iter().flat_map(|(_, sky)| sky.volume.probes()).collect()
    }

    /// Hands a volume to the device, unless it has that.
    pub fn record(&self, cmd: &mut Commands, irradiance: &IrradiancePass, sky: &SkyBuffer) {
        if self.recorded.replace(Some(sky.number)) != Some(sky.number) {
            irradiance.record_sky(cmd, &sky.words);
        }
    }
}
