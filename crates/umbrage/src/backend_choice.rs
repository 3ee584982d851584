//! Choosing a backend at run time.

use std::{fmt, str::FromStr};
use umbrage_core::{Backend, BackendError, Invalid};

/// Backend to create.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BackendChoice {
    /// wgpu if there is a hardware adapter, otherwise the CPU. [`Backend::name`] returns the one
    /// that was chosen.
    #[default]
    Auto,
    /// The CPU reference backend.
    Cpu,
    /// wgpu on any adapter, including software adapters.
    Wgpu,
}

impl FromStr for BackendChoice {
    type Err = Invalid;

    fn from_str(name: &str) -> Result<Self, Invalid> {
        match name.to_ascii_lowercase().as_str() {
            "auto" => Ok(Self::Auto),
            "cpu" => Ok(Self::Cpu),
            "wgpu" | "gpu" => Ok(Self::Wgpu),
            _ => Err(Invalid::new(
                "backend",
                format!("`{name}` is unknown"),
                "use auto, cpu or wgpu",
            )),
        }
    }
}

impl fmt::Display for BackendChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Cpu => "cpu",
            Self::Wgpu => "wgpu",
        })
    }
}

/// Creates the chosen backend.
///
/// # Errors
/// Errors if there is no adapter, or if the feature that the choice needs is disabled.
pub fn backend(choice: BackendChoice) -> Result<Box<dyn Backend>, BackendError> {
    match choice {
        BackendChoice::Cpu => cpu(),
        BackendChoice::Wgpu => gpu(true),
        BackendChoice::Auto => gpu(false).or_else(|_| cpu()).or_else(|_| gpu(true)),
    }
}

#[cfg(feature = "cpu")]
fn cpu() -> Result<Box<dyn Backend>, BackendError> {
    Ok(Box::new(umbrage_cpu::Cpu::new()))
}

#[cfg(not(feature = "cpu"))]
fn cpu() -> Result<Box<dyn Backend>, BackendError> {
    Err(switched_off("cpu").into())
}

#[cfg(feature = "wgpu")]
fn gpu(software: bool) -> Result<Box<dyn Backend>, BackendError> {
    use umbrage_wgpu::{AdapterChoice, Software};
    let software = if software {
        Software::Allowed
    } else {
        Software::Never
    };
    let choice = AdapterChoice {
        software,
        ..AdapterChoice::from_env()
    };
    Ok(Box::new(umbrage_wgpu::Gpu::new(&choice)?))
}

#[cfg(not(feature = "wgpu"))]
fn gpu(_software: bool) -> Result<Box<dyn Backend>, BackendError> {
    Err(switched_off("wgpu").into())
}

#[cfg(not(all(feature = "cpu", feature = "wgpu")))]
fn switched_off(feature: &str) -> Invalid {
    Invalid::new(
        format!("backend `{feature}`"),
        "is not part of this build",
        format!("enable umbrage's feature `{feature}`"),
    )
}
