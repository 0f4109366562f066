//! The environments of the window: the environment of the scene, the sky, the studio, and panoramas that the user drops on the window.

use std::f32::consts::PI;
use std::path::PathBuf;
use std::sync::Arc;

use leadr_gpu::Gpu;
use leadr_maps::shown::shown_path;
use leadr_render::light::environment::Environment;
use leadr_render::scene::FrameState;
use leadr_scenes::light::EnvironmentChoice;
use leadr_scenes::set::SkyOrPicture;
use leadr_tools::command::error::AppError;

/// The available environments, and the current one.
#[derive(Clone, Debug)]
pub struct Surroundings {
    choices: Vec<EnvironmentChoice>,
    shown: usize,
    made_with: SkyOrPicture,
    /// The exposure factor of the current panorama; `None` for the first environment, because the scene sets the exposure.
    metered: Option<f32>,
}

/// An environment on the device.
pub struct Lit {
    choice: EnvironmentChoice,
    environment: Environment,
    /// Exposure factor of the environment.
    metered: f32,
}

impl Surroundings {
    /// Starts with the environment `first`, which the renderer already has. `made_with` creates the other environments.
    pub fn new(first: EnvironmentChoice, made_with: SkyOrPicture) -> Self {
        let others = [EnvironmentChoice::Sky, EnvironmentChoice::Studio].into_iter().filter(|choice| *choice != first);
        let others: Vec<_> = others.collect();
        let choices = [vec![first], others].concat();
        Self { choices, shown: 0, made_with, metered: None }
    }

    /// Returns the environment after the current one.
    pub fn next(&self) -> EnvironmentChoice {
        self.choices[(self.shown + 1) % self.choices.len()].clone()
    }

    /// Returns the names of the environments, as values of `--environment`.
    pub fn names(&self) -> Vec<String> {
        let name = |choice: &EnvironmentChoice| match choice {
            EnvironmentChoice::Sky => "sky".to_owned(),
            EnvironmentChoice::Studio => "studio".to_owned(),
            EnvironmentChoice::File(path) => path.to_string_lossy().into_owned(),
        };
        self.choices.iter().map(name).collect()
    }

    /// Returns the index of the current environment.
    pub fn shown(&self) -> usize {
        self.shown
    }

    /// Returns the environment at an index. If the index is too large, returns the last environment.
    pub fn choice(&self, number: usize) -> EnvironmentChoice {
        self.choices[number.min(self.choices.len() - 1)].clone()
    }

    /// Returns the environment of a file that the user dropped on the window.
    pub fn dropped(path: PathBuf) -> Result<EnvironmentChoice, AppError> {
        let extension = path.extension().map(|e| e.to_ascii_lowercase());
        match extension.as_ref().and_then(|e| e.to_str()) {
            Some("hdr" | "exr") => Ok(EnvironmentChoice::File(path)),
            _ => Err(AppError::Usage(format!(
                "{}: drop an equirectangular .hdr or .exr picture, a model or a material",
                shown_path(path)
            ))),
        }
    }

    /// Returns the work that creates an environment, on any thread.
    pub fn loader(
        &self,
        gpu: &Arc<Gpu>,
        choice: EnvironmentChoice,
    ) -> impl FnOnce() -> Result<Lit, AppError> + Send + 'static {
        let (gpu, made_with) = (gpu.clone(), self.made_with.clone());
        move || {
            let picture = choice.load(made_with.rotation, None)?;
            let environment = made_with.make(&gpu, picture.as_ref())?;
            Ok(Lit { metered: made_with.metered(picture.as_ref()), environment, choice })
        }
    }

    /// Makes a created environment current, and returns it.
    pub fn show(&mut self, lit: Lit) -> Environment {
        self.metered = Some(lit.metered);
        self.shown = self.choices.iter().position(|known| *known == lit.choice).unwrap_or_else(|| {
            self.choices.push(lit.choice);
            self.choices.len() - 1
        });
        lit.environment
    }

    /// Adapts a state of the scene to the current environment. The function adds or removes the sky, and sets the exposure.
    pub fn light(&self, state: &mut FrameState) {
        match (&self.choices[self.shown], state.sky.is_some()) {
            (EnvironmentChoice::Sky, false) => {
                // The sun of the sky replaces the sun of a model.
                state.added_light = (state.added_light - light_of_sun(state)).max(0.0);
                *state = state.clone().under(&self.made_with.sky);
            }
            (EnvironmentChoice::Studio | EnvironmentChoice::File(_), true) => {
                let white = self.metered.map_or(1.0, f32::recip);
                if let Some(sun) = &mut state.sun {
                    sun.irradiance *= white / state.emission_scale;
                }
                (state.sky, state.emission_scale) = (None, white);
                state.added_light += light_of_sun(state);
            }
            _ => {}
        }
        if let (None, Some(metered)) = (&state.sky, self.metered) {
            (state.metered, state.emission_scale) = (metered, metered.recip());
        }
    }
}

/// Returns the irradiance of the sun of a model, relative to that of an environment with the state's white.
fn light_of_sun(state: &FrameState) -> f32 {
    state.sun.map_or(0.0, |sun| sun.irradiance.max_element()) / (PI * state.emission_scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_render::camera::Camera;
    use leadr_render::light::sky::Sky;
    use leadr_render::scene::Sun;

    fn surroundings(first: EnvironmentChoice) -> Surroundings {
        Surroundings::new(first, SkyOrPicture::under(Sky::default()))
    }

    #[test]
    fn the_sun_goes_with_its_sky() {
        let camera = Camera::looking_at(glam::Vec3::X, glam::Vec3::ZERO, 40.0);
        let mut chosen = surroundings(EnvironmentChoice::Sky);
        assert_eq!(chosen.next(), EnvironmentChoice::Studio);
        let mut state = FrameState::new(camera, Vec::new()).under(&Sky::default());
        chosen.light(&mut state);
        assert!(state.sky.is_some() && state.sun().is_some());
        chosen.shown = 1;
        chosen.light(&mut state);
        chosen.metered = Some(4.0);
        chosen.light(&mut state);
        assert!(state.sky.is_none() && state.sun().is_none());
        assert_eq!((state.exposure(), state.emission_scale), (4.0, 0.25));
        let mut chosen = surroundings(EnvironmentChoice::File("panorama.hdr".into()));
        assert_eq!(chosen.choices.len(), 3);
        chosen.light(&mut state);
        assert!(state.sky.is_none());
        chosen.shown = 1;
        chosen.light(&mut state);
        assert!(state.sky.is_some() && state.sun().is_some());
    }

    /// The exposure makes up for a model's sun in a panorama, where it adds light, and not under the sky, whose sun it replaces.
    #[test]
    fn the_sun_of_a_model_adds_light_to_panoramas_alone() {
        let camera = Camera::looking_at(glam::Vec3::X, glam::Vec3::ZERO, 40.0);
        let sun = |irradiance: f32| Sun { direction: glam::Vec3::Z, irradiance: glam::Vec3::splat(irradiance) };
        let mut chosen = surroundings(EnvironmentChoice::Studio);
        let mut state = FrameState::new(camera, Vec::new()).under(&Sky::default());
        state.sun = Some(sun(PI));
        chosen.light(&mut state);
        assert!((state.added_light - 1.0).abs() < 1e-6 && (state.exposure() - 0.5).abs() < 1e-6);
        chosen.shown = 1;
        for weak in [0.05, PI] {
            let mut state = FrameState { sun: Some(sun(weak)), added_light: weak / PI, ..state.clone() };
            chosen.light(&mut state);
            assert!(state.added_light.abs() < 1e-6 && state.sun.is_none() && state.exposure() > 0.5, "{weak}");
        }
    }

    #[test]
    fn only_pictures_can_be_dropped() {
        assert!(Surroundings::dropped("night.HDR".into()).is_ok());
        let fault = Surroundings::dropped("notes.txt".into()).expect_err("no environment");
        assert!(fault.to_string().contains("notes.txt"), "{fault}");
    }
}
