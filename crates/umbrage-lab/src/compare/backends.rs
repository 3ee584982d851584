//! The backends that take part.

use super::{Environment, Options};
use std::{fmt, str::FromStr};
use umbrage_core::{Backend, BackendError, Invalid};
use umbrage_cpu::Cpu;
use umbrage_wgpu::{AdapterChoice, Gpu};

/// Which backends take part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BackendChoice {
    /// The CPU, and wgpu if there is an adapter that can play; else a notice says why not, and what to do.
    #[default]
    Available,
    /// The CPU alone.
    Cpu,
    /// wgpu alone; an error without an adapter.
    Wgpu,
    /// Both; an error without an adapter.
    Both,
}

impl FromStr for BackendChoice {
    type Err = Invalid;

    fn from_str(name: &str) -> Result<Self, Invalid> {
        match name.to_ascii_lowercase().as_str() {
            "available" | "auto" => Ok(Self::Available),
            "cpu" => Ok(Self::Cpu),
            "wgpu" | "gpu" => Ok(Self::Wgpu),
            "both" => Ok(Self::Both),
            _ => {
                let why = format!("there is none called `{name}`");
                Err(Invalid::new(
                    "backend",
                    why,
                    "use available, cpu, wgpu or both",
                ))
            }
        }
    }
}

impl fmt::Display for BackendChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Available => "available",
            Self::Cpu => "cpu",
            Self::Wgpu => "wgpu",
            Self::Both => "both",
        })
    }
}

/// Backends, ready to play.
pub struct Backends {
    /// Those compared; the CPU comes first where it takes part.
    pub playing: Vec<Box<dyn Backend>>,
    /// What the reader of the results must know about the choice.
    pub notices: Vec<String>,
    /// The graphics adapter and its driver, if one takes part.
    pub adapter: Option<String>,
    /// Finds what truth asks about.
    pub(crate) receivers: Cpu,
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
    /// Opens the backends of a choice; `adapter` says which adapter wgpu is to use.
    ///
    /// # Errors
    /// When wgpu was asked for by name and there is no adapter that fits.
    pub fn open(choice: BackendChoice, adapter: &AdapterChoice) -> Result<Self, BackendError> {
        let mut out = Self::of(Vec::new());
        if choice != BackendChoice::Wgpu {
            out.playing.push(Box::new(Cpu::new()));
        }
        if choice == BackendChoice::Cpu {
            return Ok(out);
        }
        out.add(
            Gpu::new(adapter),
            choice == BackendChoice::Available && adapter.name.is_none(),
        )?;
        Ok(out)
    }

    /// Adds wgpu, or if the comparison may go `without` it, the reason why it is missing.
    fn add(&mut self, gpu: Result<Gpu, BackendError>, without: bool) -> Result<(), BackendError> {
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
            // An adapter asked for by name must be there. One that was merely found may be of no use: its driver may be too
            // old, or the graphics API that the environment names may lack what is needed.
            Err(e) if without => {
                self.notices.push(format!(
                    "Compared on the CPU alone, as wgpu could not be opened: {e}."
                ));
            }
            Err(e) => return Err(e),
        }
        Ok(())
    }

    /// Backends of the caller's own. Agreement is measured against the first if its kind is `cpu`.
    pub fn of(playing: Vec<Box<dyn Backend>>) -> Self {
        Self {
            playing,
            notices: Vec::new(),
            adapter: None,
            receivers: Cpu::new(),
        }
    }

    /// Where a comparison with these backends is made, and when, if it has times.
    pub fn environment(&self, options: &Options) -> Environment {
        let backends = self.playing.iter().map(|b| b.name().to_owned()).collect();
        let snapping = self
            .playing
            .iter()
            .find(|b| b.kind() != "cpu")
            .map(|b| b.snapping().to_string());
        let adapter = self.adapter.clone();
        Environment {
            adapter,
            snapping,
            backends,
            ..Environment::here(options.runs.is_some())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An adapter that can't play is as good as none, whatever it can't do: asked for, it is an error; else the CPU goes on
    /// and says why.
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
                mend: "install one".into(),
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
