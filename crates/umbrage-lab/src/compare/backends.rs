//! The backends that are compared.

use super::{
    kept_truth::KeptTruth, options::CompareOptions, result::Environment, timing::DeviceClock,
};
use std::fmt;
use umbrage_core::{Backend, BackendError};
use umbrage_cpu::Cpu;
use umbrage_wgpu::{AdapterChoice, Gpu};

/// Opened backends.
pub struct Backends {
    /// The backends to compare. The CPU is the first if it is one of them.
    pub backends: Vec<Box<dyn Backend + Send>>,
    /// Notices about the choice, for the reader of the results.
    pub notices: Vec<String>,
    /// The graphics adapter and its driver, if one is used.
    pub adapter: Option<String>,
    /// Storage for truth between runs. `None` if truth is not stored.
    pub kept_truth: Option<KeptTruth>,
    /// Backend that finds the receivers for truth.
    pub(crate) receivers: Cpu,
    /// Clock state of the graphics device.
    pub(crate) device_clock: DeviceClock,
}

impl fmt::Debug for Backends {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.backends.iter().map(|b| b.name()).collect();
        f.debug_struct("Backends")
            .field("playing", &names)
            .field("notices", &self.notices)
            .finish_non_exhaustive()
    }
}

impl Backends {
    /// Returns the CPU only.
    pub fn cpu() -> Self {
        Self::from_backends(vec![Box::new(Cpu::new())])
    }

    /// Returns wgpu only, on the requested adapter.
    ///
    /// # Errors
    /// Errors if there is no suitable adapter.
    pub fn wgpu(adapter: &AdapterChoice) -> Result<Self, BackendError> {
        let mut out = Self::from_backends(Vec::new());
        out.add(Gpu::new(adapter), false)?;
        Ok(out)
    }

    /// Returns the CPU and wgpu.
    ///
    /// # Errors
    /// Errors if there is no suitable adapter.
    pub fn both(adapter: &AdapterChoice) -> Result<Self, BackendError> {
        let mut out = Self::cpu();
        out.add(Gpu::new(adapter), false)?;
        Ok(out)
    }

    /// Returns the CPU, and wgpu if there is a suitable adapter. Otherwise a notice states the
    /// reason and a remedy.
    ///
    /// # Errors
    /// Errors if an adapter was requested by name and isn't suitable.
    pub fn available(adapter: &AdapterChoice) -> Result<Self, BackendError> {
        let mut out = Self::cpu();
        out.add(Gpu::new(adapter), adapter.name.is_none())?;
        Ok(out)
    }

    /// Adds wgpu. If it can't be opened and `may_be_missing`, adds a notice instead.
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
                self.backends.push(Box::new(gpu));
            }
            // An adapter requested by name must exist. Any other may be unusable: its driver may be
            // too old, or the graphics API named by the environment may lack features.
            Err(e) if may_be_missing => {
                self.notices.push(format!(
                    "Compared on the CPU alone: wgpu could not be opened: {e}."
                ));
            }
            Err(e) => return Err(e),
        }
        Ok(())
    }

    /// Returns the caller's backends. Agreement is measured against the first one if its kind is
    /// `cpu`.
    pub fn from_backends(backends: Vec<Box<dyn Backend + Send>>) -> Self {
        Self {
            backends,
            notices: Vec::new(),
            adapter: None,
            kept_truth: None,
            receivers: Cpu::new(),
            device_clock: DeviceClock::new(None),
        }
    }

    /// Returns the environment of a comparison with these backends, and the date if it has times.
    pub fn environment(&self, options: &CompareOptions) -> Environment {
        let backends = self.backends.iter().map(|b| b.name().to_owned()).collect();
        let snapping = self
            .backends
            .iter()
            .find(|b| b.kind() != "cpu")
            .map(|b| b.snapping().to_string());
        Environment {
            adapter: self.adapter.clone(),
            snapping,
            backends,
            ..Environment::of_this_machine(options.runs.is_some())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::Invalid;

    /// An unsuitable adapter counts as a missing one. If it was requested, this is an error;
    /// otherwise only the CPU is used, with a notice.
    #[test]
    fn an_adapter_that_cannot_run_leaves_the_cpu() {
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
            let mut backends = Backends::from_backends(vec![Box::new(Cpu::new())]);
            assert!(
                backends.add(Err(error()), false).is_err() && backends.notices.is_empty(),
                "requested by name"
            );
            backends.add(Err(error()), true).expect("the CPU remains");
            let (notices, why) = (&backends.notices, error().to_string());
            assert!(
                notices.len() == 1 && notices[0].contains(&why) && notices[0].contains("CPU alone"),
                "{notices:?}"
            );
            assert_eq!(
                (backends.backends.len(), backends.backends[0].kind()),
                (1, "cpu")
            );
        }
    }
}
