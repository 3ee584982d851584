//! Whether there is a graphics adapter, and how to come by one.

use crate::run::{beside, run, spell};
use anyhow::{Context as _, Result, bail};
use std::{fs, process::Command};

const PACKAGES: [&str; 2] = ["mesa-vulkan-drivers", "libvulkan1"];

/// The name of the adapter that the tests will use. `cargo test` has built the program that tells,
/// beside this one.
pub(crate) fn find() -> Result<Option<String>> {
    find_with(|_| ())
}

/// Checks that the tests' adapter is the driver on which bits are promised.
pub(crate) fn check_pinned() -> Result<()> {
    let mut program = beside("adapter")?;
    run(with_runtime_dir(program.arg("--pinned"))?)
        .context("bits can't be compared here: install Mesa 22.3.6 (Debian 12), or leave out --pinned-driver")
}

/// The same once the program's environment is prepared.
pub(crate) fn find_with(prepare: impl FnOnce(&mut Command)) -> Result<Option<String>> {
    let mut program = beside("adapter")?;
    prepare(&mut program);
    let output = with_runtime_dir(&mut program)?
        .output()
        .context("the program `adapter` did not start")?;
    let name = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    Ok(output.status.success().then_some(name))
}

/// Mesa complains on every start where this variable is missing.
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

/// Returns whether any Vulkan driver is installed, as far as files tell; [`find`] tells whether it
/// has an adapter. Elsewhere than on Debian and Ubuntu files tell nothing, and the answer is yes.
pub(crate) fn has_driver() -> bool {
    let holds_any =
        |folder: &str| fs::read_dir(folder).is_ok_and(|entries| entries.flatten().next().is_some());
    !is_debian() || MANIFESTS.into_iter().any(holds_any)
}

/// Installs Mesa's software driver on Debian and Ubuntu.
pub(crate) fn install_driver() -> Result<()> {
    if !is_debian() {
        bail!(
            "no graphics adapter, and --install-driver only knows Debian and Ubuntu: install a Vulkan driver"
        );
    }
    let Some(prefix) = privilege() else {
        bail!(
            "no graphics adapter, and no rights to install one: as root, run `{}`",
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

/// The one line that does what [`install_driver`] does.
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

/// What must stand before a command that installs: nothing for root, `sudo -n` if that works
/// without asking.
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
