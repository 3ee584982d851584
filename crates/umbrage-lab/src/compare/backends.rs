//! The backends that are compared.

use super::{
    kept_truth::KeptTruth, options::CompareOptions, result::Environment, timing::DeviceClock,
};
use std::fmt;
use umbrage_core::{Backend, BackendError};
use umbrage_cpu::Cpu;
use umbrage_wgpu::{AdapterChoice, Gpu};

/// Backends, ready to play.
pub struct Backends {
    /// Those compared; the CPU comes first where it takes part.
    pub playing: Vec<Box<dyn Backend + Send>>,
    /// What the reader of the results must know about the choice.
    pub notices: Vec<String>,
    /// The graphics adapter and its driver, if one takes part.
    pub adapter: Option<String>,
    /// Where truth is kept between runs; none: nowhere.
    pub kept_truth: Option<KeptTruth>,
    /// Finds the receivers that truth is traced at.
    pub(crate) receivers: Cpu,
    /// What is known of the graphics device's clock.
    pub(crate) device_clock: DeviceClock,
}

impl fmt::Debug for Backends {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.playing.iter().map(|b| b.name()).collect();
        f.debug_struct("Backends")
            .field("playing", &names)
            .field("notices", &self.notices)
            .finish_non_exhaustive()
    }
}

impl Backends {
    /// The CPU alone.
    pub fn cpu() -> Self {
        Self::of(vec![Box::new(Cpu::new())])
    }

    /// wgpu alone, on the adapter asked for.
    ///
    /// # Errors
    /// Errors if there is no adapter that fits.
    pub fn wgpu(adapter: &AdapterChoice) -> Result<Self, BackendError> {
        let mut out = Self::of(Vec::new());
        out.add(Gpu::new(adapter), false)?;
        Ok(out)
    }

    /// The CPU and wgpu.
    ///
    /// # Errors
    /// Errors if there is no adapter that fits.
    pub fn both(adapter: &AdapterChoice) -> Result<Self, BackendError> {
        let mut out = Self::cpu();
        out.add(Gpu::new(adapter), false)?;
        Ok(out)
    }

    /// The CPU, and wgpu if there is an adapter that can play; else a notice says why not, and what
    /// to do.
    ///
    /// # Errors
    /// Errors if an adapter was asked for by name and does not fit.
    pub fn available(adapter: &AdapterChoice) -> Result<Self, BackendError> {
        let mut out = Self::cpu();
        out.add(Gpu::new(adapter), adapter.name.is_none())?;
        Ok(out)
    }

    /// Adds wgpu, or if it `may_be_missing`, a notice that says why it is.
    fn add(
        &mut self,
        gpu: Result<Gpu, BackendError>,
        may_be_missing: bool,
    ) -> Result<(), BackendError> {
        match gpu {
            Ok(gpu) => {
                let info = gpu.adapter_info();
                let driver = format!("{} {}", info.driver, info.driver_info);
                self.adapter = Some(format!(
                    "{} ({}; {})",
                    info.name,
                    info.backend,
                    driver.trim()
                ));
                self.playing.push(Box::new(gpu));
            }
            // An adapter asked for by name must be there. One that was merely found may be of no
            // use: its driver may be too old, or the graphics API that the environment names may
            // lack what is needed.
            Err(e) if may_be_missing => {
                self.notices.push(format!(
                    "Compared on the CPU alone, as wgpu could not be opened: {e}."
                ));
            }
            Err(e) => return Err(e),
        }
        Ok(())
    }

    /// Returns the caller's own backends. Agreement is measured against the first if its kind is
    /// `cpu`.
    pub fn of(playing: Vec<Box<dyn Backend + Send>>) -> Self {
        Self {
            playing,
            notices: Vec::new(),
            adapter: None,
            kept_truth: None,
            receivers: Cpu::new(),
            device_clock: DeviceClock::new(None),
        }
    }

    /// Returns where a comparison with these backends is made, and when, if it has times.
    pub fn environment(&self, options: &CompareOptions) -> Environment {
        let backends = self.playing.iter().map(|b| b.name().to_owned()).collect();
        let snapping = self
            .playing
            .iter()
            .find(|b| b.kind() != "cpu")
            .map(|b| b.snapping().to_string());
        Environment {
            adapter: self.adapter.clone(),
            snapping,
            backends,
            ..Environment::here(options.runs.is_some())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::Invalid;

    /// An adapter that can't play is as good as none, whatever it can't do: asked for, it is an
    /// error; else the CPU goes on and says why.
    #[test]
    fn an_adapter_that_cannot_play_leaves_the_cpu() {
        let errors: [fn() -> BackendError; 3] = [
            || {
                Invalid::new(
                    "graphics adapter x (gl)",
                    "cannot draw into R32Float images",
                    "choose another",
                )
                .into()
            },
            || BackendError::DeviceLost("gone".to_owned()),
            || BackendError::NoAdapter {
                wanted: "any".into(),
                found: "none".into(),
                help: "install one".into(),
            },
        ];
        for error in errors {
            let mut backends = Backends::of(vec![Box::new(Cpu::new())]);
            assert!(
                backends.add(Err(error()), false).is_err() && backends.notices.is_empty(),
                "asked for by name"
            );
            backends.add(Err(error()), true).expect("the CPU plays");
            let (notices, why) = (&backends.notices, error().to_string());
            assert!(
                notices.len() == 1 && notices[0].contains(&why) && notices[0].contains("CPU alone"),
                "{notices:?}"
            );
            assert_eq!(
                (backends.playing.len(), backends.playing[0].kind()),
                (1, "cpu")
            );
        }
    }
}
