//! `leadr bake --cone-table`: the reflectance of rough specular surfaces under light through a cone (Chan 2018, figure 19).

use std::fmt;
use std::path::PathBuf;

use serde::Serialize;

use super::args::BakeArgs;
use leadr_maps::RgbImage;
use leadr_maps::save::save_exr_rgb;
use leadr_maps::shown::shown_path;
use leadr_reflectance::visible::cone_specular::{CONE_TABLE, ConeTable};
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::{begin, extension};
use leadr_tools::command::output::Output;

/// The result for a table.
#[derive(Debug, Serialize)]
struct ConeTableReport {
    command: &'static str,
    output: PathBuf,
    /// The numbers of viewer's cosines, glosses and cones.
    size: [usize; 3],
}

impl fmt::Display for ConeTableReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.size;
        write!(f, "{}: {x} cosines x {y} glosses x {z} cones, side by side", shown_path(&self.output))
    }
}

/// Writes the table as a picture: a square per cone from the open hemisphere to the closed cone, with the viewer's cosine to the right and
/// the gloss downwards. Red is the factor of F0, and green is added to the product.
pub fn run(arguments: &BakeArgs, output: &Output) -> Result<(), AppError> {
    let file = &arguments.output;
    if extension(file).as_deref() != Some("exr") {
        let shown = shown_path(file);
        return Err(AppError::Usage(format!("'{shown}' must end in .exr, the format of --cone-table")));
    }
    drop(begin(file)?);
    let table = ConeTable::new(|gloss| arguments.gloss_scale.alpha(gloss));
    let [nx, ny, nz] = CONE_TABLE;
    let texel = |i: usize| {
        let (x, y) = (i % (nx * nz), i / (nx * nz));
        let [scale, bias] = table.texels()[x % nx + nx * (y + ny * (x / nx))];
        [scale, bias, 0.0]
    };
    let texels = (0..nx * ny * nz).map(texel).collect();
    save_exr_rgb(file, &RgbImage { width: (nx * nz) as u32, height: ny as u32, texels })?;
    output.result(&ConeTableReport { command: "bake", output: file.clone(), size: CONE_TABLE })
}
