//! Assembly of all WGSL that this crate compiles or returns.
//!
//! * **Imports.** A line `// import NAME` of a `.wgsl` file lists the files that it needs. A
//!   kernel's modules are a list in Rust.
//! * **Conditions.** A `const`, such as `NORMALS_ARE_HALVED`, selects the variant in the files that
//!   read it. Text that users compile has no `override`.
//! * **Bindings.** A kernel reads `kernel`, `load_0`, `table_0` and so on, as described in
//!   [`Kernel`](umbrage_core::Kernel). `kernel.rs` declares them as bindings of one kernel,
//!   `set.rs` as parts of arrays that all lights of a set share.
//! * **Prefixes.** A prefix before every name that a text declares allows several texts in one
//!   shader.
//!
//! Only `resolver.rs` modifies texts. `stages.rs` lists the files.

pub(crate) mod kernel;
pub(crate) mod resolver;
pub(crate) mod set;
pub(crate) mod stages;
