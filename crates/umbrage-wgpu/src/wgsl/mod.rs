//! WGSL: every text that this crate compiles or returns is assembled here.
//!
//! * **Imports.** A `.wgsl` file names the files that it needs in a line `// import NAME`. A
//!   kernel's modules are a list in Rust.
//! * **Conditions.** A `const`, such as `NORMALS_ARE_HALVED`, selects the variant in the files that
//!   read it. Text that users compile has no `override`.
//! * **Bindings.** A kernel reads `kernel`, `load_0`, `table_0` and so on, as
//!   [`Kernel`](umbrage_core::Kernel) describes. `kernel.rs` declares them as bindings of one
//!   kernel, `set.rs` as parts of arrays that all lights of a set share.
//! * **Prefixes.** A prefix before every name that a text declares lets several texts fit into one
//!   shader.
//!
//! `resolver.rs` does all of this to texts, and is the one module that changes them. `stages.rs`
//! lists the files.

pub(crate) mod kernel;
pub(crate) mod resolver;
pub(crate) mod set;
pub(crate) mod stages;
