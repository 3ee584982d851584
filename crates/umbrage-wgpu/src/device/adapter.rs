//! Choice of a graphics adapter.

use umbrage_core::BackendError;
use wgpu::{Adapter, Backends, DeviceType, Instance, InstanceDescriptor, PowerPreference};

/// Choice of a graphics adapter. The default is the most powerful hardware, or a software driver if
/// there is no hardware.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterChoice {
    /// Part of the adapter's name, in any case: `nvidia`, `llvmpipe`.
    pub name: Option<String>,
    /// Preference for discrete or integrated hardware.
    pub power: PowerPreference,
    /// Use of software drivers (lavapipe, SwiftShader, WARP).
    pub software: Software,
    /// Graphics APIs. OpenGL is only used if listed: many of its drivers cannot draw into float
    /// images.
    pub backends: Backends,
}

/// Use of drivers that run on the CPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Software {
    /// Used only if there is no hardware.
    #[default]
    Allowed,
    /// No other adapters: for results that don't depend on the machine.
    Only,
    /// Never used.
    Never,
}

impl Default for AdapterChoice {
    fn default() -> Self {
        Self {
            name: None,
            power: PowerPreference::None,
            software: Software::Allowed,
            backends: Backends::PRIMARY,
        }
    }
}

impl AdapterChoice {
    /// Returns the default, modified by the usual environment variables of wgpu programs:
    /// `WGPU_ADAPTER_NAME`, `WGPU_POWER_PREF` (`low`, `high`) and `WGPU_BACKEND` (`vulkan`, `gl`,
    /// ..).
    pub fn from_env() -> Self {
        let default = Self::default();
        let name = std::env::var("WGPU_ADAPTER_NAME").unwrap_or_default();
        Self {
            name: if name.is_empty() { None } else { Some(name) },
            power: PowerPreference::from_env().unwrap_or(default.power),
            backends: Backends::from_env().unwrap_or(default.backends),
            ..default
        }
    }

    /// Returns the adapter that matches best.
    pub(crate) fn find(&self) -> Result<Adapter, BackendError> {
        let mut desc = InstanceDescriptor::new_without_display_handle_from_env();
        desc.backends = self.backends;
        let adapters = pollster::block_on(Instance::new(desc).enumerate_adapters(self.backends));
        let found: Vec<String> = adapters.iter().map(|a| describe(&a.get_info())).collect();
        adapters
            .into_iter()
            .filter(|adapter| self.fits(&adapter.get_info()))
            .min_by_key(|adapter| self.rank(&adapter.get_info()))
            .ok_or_else(|| self.no_adapter(&found))
    }

    fn fits(&self, info: &wgpu::AdapterInfo) -> bool {
        let is_named = match &self.name {
            Some(name) => info.name.to_lowercase().contains(&name.to_lowercase()),
            None => true,
        };
        let is_software = info.device_type == DeviceType::Cpu;
        let is_of_kind = match self.software {
            Software::Allowed => true,
            Software::Only => is_software,
            Software::Never => !is_software,
        };
        is_named && is_of_kind
    }

    /// Returns a sort key that puts better adapters first: the kind of hardware, then whether the
    /// API is OpenGL.
    fn rank(&self, info: &wgpu::AdapterInfo) -> (u8, bool) {
        let saves_power = self.power == PowerPreference::LowPower;
        let kind = match info.device_type {
            DeviceType::DiscreteGpu => u8::from(saves_power),
            DeviceType::IntegratedGpu => u8::from(!saves_power),
            DeviceType::VirtualGpu => 2,
            DeviceType::Other => 3,
            DeviceType::Cpu => 4,
        };
        (kind, info.backend == wgpu::Backend::Gl)
    }

    fn no_adapter(&self, found: &[String]) -> BackendError {
        let mut help =
            "install the graphics card's Vulkan driver, or a software one (Debian and Ubuntu: \
                        `apt-get install mesa-vulkan-drivers libvulkan1`)"
                .to_owned();
        if !found.is_empty() {
            help = format!("request one of those found, or {help}");
        }
        let found = if found.is_empty() {
            "none".to_owned()
        } else {
            found.join("; ")
        };
        BackendError::NoAdapter {
            wanted: self.to_string(),
            found,
            help,
        }
    }
}

impl std::fmt::Display for AdapterChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let software = match self.software {
            Software::Allowed => "any adapter",
            Software::Only => "a software adapter",
            Software::Never => "a hardware adapter",
        };
        f.write_str(software)?;
        if let Some(name) = &self.name {
            write!(f, " named `{name}`")?;
        }
        if self.backends == Self::default().backends {
            return Ok(());
        }
        let names: Vec<_> = self
            .backends
            .iter_names()
            .map(|(name, _)| name.to_lowercase())
            .collect();
        let api = if names.is_empty() {
            "no graphics API".to_owned()
        } else {
            names.join(" or ")
        };
        write!(f, " for {api}")
    }
}

fn describe(info: &wgpu::AdapterInfo) -> String {
    format!("{} ({})", info.name, info.backend)
}
