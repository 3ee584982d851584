//! Finds or installs a graphics adapter.

use crate::run::{run, sibling_program, spell};
use anyhow::{Context as _, Result, bail};
use std::{fs, process::Command};

const PACKAGES: [&str; 2] = ["mesa-vulkan-drivers", "libvulkan1"];

/// Returns the name of the tests' adapter. `cargo test` has built the program that reports it, next
/// to this one.
pub(crate) fn find() -> Result<Option<String>> {
    find_with(|_| ())
}

/// Checks that the tests' adapter is the driver with the promised bits.
pub(crate) fn check_pinned() -> Result<()> {
    let mut program = sibling_program("adapter")?;
    run(with_runtime_dir(program.arg("--pinned"))?)
        .context("bits can't be compared on this driver: install Mesa 22.3.6 (Debian 12), or omit --pinned-driver")
}

/// Returns the name of the tests' adapter in an environment that `prepare` sets up.
pub(crate) fn find_with(prepare: impl FnOnce(&mut Command)) -> Result<Option<String>> {
    let mut program = sibling_program("adapter")?;
    prepare(&mut program);
    let output = with_runtime_dir(&mut program)?
        .output()
        .context("the program `adapter` did not start")?;
    let name = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    Ok(output.status.success().then_some(name))
}

/// Sets `XDG_RUNTIME_DIR`, as Mesa prints a warning on every start without it.
pub(crate) fn with_runtime_dir(command: &mut Command) -> Result<&mut Command> {
    if cfg!(not(unix)) || std::env::var_os("XDG_RUNTIME_DIR").is_some() {
        return Ok(command);
    }
    let dir = std::env::temp_dir().join(format!("umbrage-runtime-{}", std::process::id()));
    fs::create_dir_all(&dir).with_context(|| format!("cannot make {}", dir.display()))?;
    #[cfg(unix)]
    fs::set_permissions(&dir, std::os::unix::fs::PermissionsExt::from_mode(0o700))?;
    Ok(command.env("XDG_RUNTIME_DIR", dir))
}

/// Folders in which Vulkan's loader looks for drivers' manifests on Debian and Ubuntu.
const MANIFESTS: [&str; 2] = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"];

/// Reports whether any Vulkan driver is installed, judged by files on Debian and Ubuntu; `true` on
/// other systems. [`find`] checks for an adapter.
pub(crate) fn has_driver() -> bool {
    let holds_any =
        |folder: &str| fs::read_dir(folder).is_ok_and(|entries| entries.flatten().next().is_some());
    !is_debian() || MANIFESTS.into_iter().any(holds_any)
}

/// Installs Mesa's software driver on Debian and Ubuntu.
pub(crate) fn install_driver() -> Result<()> {
    if !is_debian() {
        bail!(
            "no graphics adapter, and --install-driver only supports Debian and Ubuntu: install a Vulkan driver"
        );
    }
    let Some(prefix) = privilege() else {
        bail!(
            "no graphics adapter, and no permission to install one: as root, run `{}`",
            by_hand()
        );
    };
    println!(
        "no graphics adapter found: installing {} with apt-get",
        PACKAGES.join(" and ")
    );
    // A container's package lists may be missing or old.
    run(apt_get(prefix).arg("update"))?;
    run(apt_get(prefix)
        .args(["install", "-y", "--no-install-recommends"])
        .args(PACKAGES))?;
    println!("installed {}", PACKAGES.join(" and "));
    Ok(())
}

/// Returns the command line that does the same as [`install_driver`].
pub(crate) fn by_hand() -> String {
    let update = spell(apt_get(&[]).arg("update"));
    let install = spell(
        apt_get(&[])
            .args(["install", "-y", "--no-install-recommends"])
            .args(PACKAGES),
    );
    format!("{update} && {install}")
}

pub(crate) fn is_debian() -> bool {
    let text = fs::read_to_string("/etc/os-release").unwrap_or_default();
    let ids = text
        .lines()
        .filter_map(|l| l.strip_prefix("ID=").or_else(|| l.strip_prefix("ID_LIKE=")));
    ids.flat_map(|l| l.trim_matches('"').split_whitespace())
        .any(|id| id == "debian" || id == "ubuntu")
}

/// Returns the prefix of an install command: nothing for root, `sudo -n` if that works without a
/// password.
pub(crate) fn privilege() -> Option<&'static [&'static str]> {
    let id = Command::new("id").arg("-u").output().ok()?;
    if id.stdout.trim_ascii() == b"0" {
        return Some(&[]);
    }
    let sudo = Command::new("sudo").args(["-n", "true"]).output().ok()?;
    sudo.status.success().then_some(&["sudo", "-n"])
}

pub(crate) fn apt_get(prefix: &[&str]) -> Command {
    let mut words = prefix.iter().copied().chain(["apt-get"]);
    let mut command = Command::new(words.next().unwrap_or("apt-get"));
    command.args(words).env("DEBIAN_FRONTEND", "noninteractive");
    command
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_line_to_run_names_both_packages() {
        assert_eq!(
            super::by_hand(),
            "apt-get update && apt-get install -y --no-install-recommends mesa-vulkan-drivers libvulkan1"
        );
    }
}
