//! Checksums of what is written, so that what was changed or cut off since is noticed, and of what
//! writes it.

use std::{
    fs,
    hash::{DefaultHasher, Hash, Hasher},
};

/// Returns the 64-bit FNV-1a hash (Fowler, Noll and Vo) as sixteen hexadecimal digits: the same for
/// every version of the compiler, and different for any two texts that differ in one character.
pub(crate) fn checksum(bytes: &[u8]) -> String {
    const OFFSET_BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0100_0000_01b3;
    let mut hash = OFFSET_BASIS;
    for &byte in bytes {
        hash = (hash ^ u64::from(byte)).wrapping_mul(PRIME);
    }
    format!("{hash:016x}")
}

/// Returns a hash of the program that runs; empty if the system doesn't say where it is.
pub(crate) fn program_hash() -> String {
    std::env::current_exe()
        .and_then(fs::read)
        .map(|bytes| hash(&bytes))
        .unwrap_or_default()
}

/// Returns a hash that is the same in all programs of one version of the compiler.
pub(crate) fn hash<T: Hash + ?Sized>(value: &T) -> String {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}
