//! Detection of operations in a shader's functions whose results depend on the driver.
//!
//! WGSL permits drivers to fuse a product with a sum, to compute built-ins such as `dot` in any
//! order, and to return inexact quotients and roots. The search works on naga's representation,
//! across all functions: a product is followed through variables, parameters, results, structures
//! and signs.

use naga::{
    BinaryOperator, Block, Expression, Function, GlobalVariable, Handle, Literal, MathFunction,
    Module, ScalarKind, Statement, TypeInner, UnaryOperator,
    front::wgsl::parse_str,
    valid::{Capabilities, FunctionInfo, ModuleInfo, ValidationFlags, Validator},
};
use std::{
    collections::{BTreeSet, HashMap, HashSet},
    fmt,
};

/// An operation whose result depends on the driver.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Liberty {
    /// A product goes into a sum or difference.
    FusibleSum,
    /// A built-in function, or a product of matrices, that contains sums.
    FusibleBuiltIn(String),
    /// A quotient.
    Quotient,
    /// A square root, or its inverse.
    Root,
}

impl fmt::Display for Liberty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FusibleSum => write!(f, "a product in a sum: write `product(a, b)`"),
            Self::FusibleBuiltIn(name) => write!(f, "{name}: write its sum out with `product`"),
            Self::Quotient => write!(f, "a bare quotient: write `quotient(a, b)`"),
            Self::Root => write!(f, "a bare root: write `root(x)`"),
        }
    }
}

/// Returns each function of a shader with the liberties that it leaves to drivers, in the order of
/// names.
///
/// # Errors
/// Returns an error if the text is not valid WGSL.
pub fn liberties(wgsl: &str) -> Result<BTreeSet<(String, Liberty)>, String> {
    let module = parse_str(wgsl).map_err(|e| e.emit_to_string(wgsl))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|e| e.emit_to_string(wgsl))?;
    let mut products = Products::default();
    while products.spread(&module) {}
    let mut out = BTreeSet::new();
    for (key, name, function, info) in functions(&module, &info) {
        for (handle, expression) in function.expressions.iter() {
            if let Some(liberty) =
                products.liberty(&module, key, function, info, handle, expression)
            {
                out.insert((name.clone(), liberty));
            }
        }
    }
    Ok(out)
}

/// Returns the functions among `roots`, and the entry points, in which a variable of this name may
/// guard a product before the variable is stored to, while compilers know its initial value.
///
/// # Errors
/// Returns an error if the text is not valid WGSL, or has none of `roots`.
pub fn unset_guards(wgsl: &str, guard: &str, roots: &[&str]) -> Result<Vec<String>, String> {
    let module = parse_str(wgsl).map_err(|e| e.emit_to_string(wgsl))?;
    let mut globals = module.global_variables.iter();
    let Some((guard, _)) = globals.find(|(_, global)| global.name.as_deref() == Some(guard)) else {
        return Ok(Vec::new());
    };
    let mut checked: Vec<(&str, &Function)> = Vec::new();
    for &root in roots {
        let mut functions = module.functions.iter();
        let found = functions.find(|(_, function)| function.name.as_deref() == Some(root));
        let (_, function) = found.ok_or_else(|| format!("there is no function `{root}`"))?;
        checked.push((root, function));
    }
    let entries = module.entry_points.iter();
    checked.extend(entries.map(|entry| (entry.name.as_str(), &entry.function)));
    let order = Order {
        module: &module,
        guard,
    };
    let unset = checked
        .into_iter()
        .filter(|(_, function)| order.loads_first(function, &function.body, &mut false));
    Ok(unset.map(|(name, _)| name.to_owned()).collect())
}

/// The order in which functions load and store a variable.
struct Order<'a> {
    module: &'a Module,
    guard: Handle<GlobalVariable>,
}

impl Order<'_> {
    fn is_guard(&self, function: &Function, pointer: Handle<Expression>) -> bool {
        matches!(*root(function, pointer), Expression::GlobalVariable(global) if global == self.guard)
    }

    /// Reports whether a block may load the variable before it is stored to. `is_set` is whether a
    /// store preceded the block, and afterwards, whether one occurred on all paths through it.
    fn loads_first(&self, function: &Function, block: &Block, is_set: &mut bool) -> bool {
        for statement in block.iter() {
            if *is_set {
                return false;
            }
            let in_block =
                |block: &Block, is_set: &mut bool| self.loads_first(function, block, is_set);
            let loads = match statement {
                Statement::Emit(range) => range.clone().any(|expression| {
                    matches!(
                        function.expressions[expression],
                        Expression::Load { pointer } if self.is_guard(function, pointer)
                    )
                }),
                Statement::Store { pointer, .. } => {
                    *is_set = self.is_guard(function, *pointer);
                    false
                }
                Statement::Call {
                    function: callee, ..
                } => {
                    let callee = &self.module.functions[*callee];
                    self.loads_first(callee, &callee.body, is_set)
                }
                Statement::Block(block) => in_block(block, is_set),
                Statement::If { accept, reject, .. } => {
                    let [mut after_accept, mut after_reject] = [false; 2];
                    let loads =
                        in_block(accept, &mut after_accept) || in_block(reject, &mut after_reject);
                    *is_set = after_accept && after_reject;
                    loads
                }
                // Ignore stores in cases, which may be skipped, and in loops, which may end early.
                Statement::Switch { cases, .. } => {
                    cases.iter().any(|case| in_block(&case.body, &mut false))
                }
                Statement::Loop {
                    body, continuing, ..
                } => in_block(body, &mut false) || in_block(continuing, &mut false),
                _ => false,
            };
            if loads {
                return true;
            }
        }
        false
    }
}

/// A function, or an entry point by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Key {
    Function(Handle<Function>),
    Entry(usize),
}

fn functions<'a>(
    module: &'a Module,
    info: &'a ModuleInfo,
) -> Vec<(Key, String, &'a Function, &'a FunctionInfo)> {
    let named = module.functions.iter().map(|(handle, function)| {
        let name = function.name.clone().unwrap_or_default();
        (Key::Function(handle), name, function, &info[handle])
    });
    let entries = module.entry_points.iter().enumerate().map(|(i, entry)| {
        let info = info.get_entry_point(i);
        (Key::Entry(i), entry.name.clone(), &entry.function, info)
    });
    named.chain(entries).collect()
}

/// The expressions that may be products.
#[derive(Debug, Default)]
struct Products {
    expressions: HashMap<Key, HashSet<Handle<Expression>>>,
    arguments: HashSet<(Handle<Function>, u32)>,
    results: HashSet<Handle<Function>>,
    locals: HashSet<(Key, Handle<naga::LocalVariable>)>,
    globals: HashSet<Handle<naga::GlobalVariable>>,
}

impl Products {
    fn contains(&self, key: Key, expression: Handle<Expression>) -> bool {
        self.expressions
            .get(&key)
            .is_some_and(|set| set.contains(&expression))
    }

    fn len(&self) -> usize {
        let expressions: usize = self.expressions.values().map(HashSet::len).sum();
        expressions
            + self.arguments.len()
            + self.results.len()
            + self.locals.len()
            + self.globals.len()
    }

    /// Propagates products by one step. Returns whether there are new ones.
    fn spread(&mut self, module: &Module) -> bool {
        let before = self.len();
        for (handle, function) in module.functions.iter() {
            self.spread_in(Key::Function(handle), module, function);
        }
        for (i, entry) in module.entry_points.iter().enumerate() {
            self.spread_in(Key::Entry(i), module, &entry.function);
        }
        self.len() > before
    }

    fn spread_in(&mut self, key: Key, module: &Module, function: &Function) {
        for (handle, expression) in function.expressions.iter() {
            if self.is_product(key, module, function, expression) {
                self.expressions.entry(key).or_default().insert(handle);
            }
        }
        self.spread_in_block(key, function, &function.body);
    }

    fn is_product(
        &self,
        key: Key,
        module: &Module,
        function: &Function,
        expression: &Expression,
    ) -> bool {
        let has = |handle| self.contains(key, handle);
        match *expression {
            Expression::Binary {
                op: BinaryOperator::Multiply,
                left,
                right,
            } => {
                !is_power_of_two(module, function, left)
                    && !is_power_of_two(module, function, right)
            }
            Expression::Unary {
                op: UnaryOperator::Negate,
                expr,
            } => has(expr),
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => has(base),
            Expression::Splat { value, .. } => has(value),
            Expression::Swizzle { vector, .. } => has(vector),
            Expression::Compose { ref components, .. } => components.iter().any(|&c| has(c)),
            Expression::Select { accept, reject, .. } => has(accept) || has(reject),
            Expression::Load { pointer } => match root(function, pointer) {
                Expression::LocalVariable(local) => self.locals.contains(&(key, *local)),
                Expression::GlobalVariable(global) => self.globals.contains(global),
                _ => false,
            },
            Expression::FunctionArgument(i) => match key {
                Key::Function(handle) => self.arguments.contains(&(handle, i)),
                Key::Entry(_) => false,
            },
            Expression::CallResult(callee) => self.results.contains(&callee),
            _ => false,
        }
    }

    fn spread_in_block(&mut self, key: Key, function: &Function, block: &Block) {
        for statement in block.iter() {
            match statement {
                Statement::Block(block) => self.spread_in_block(key, function, block),
                Statement::If { accept, reject, .. } => {
                    self.spread_in_block(key, function, accept);
                    self.spread_in_block(key, function, reject);
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        self.spread_in_block(key, function, &case.body);
                    }
                }
                Statement::Loop {
                    body, continuing, ..
                } => {
                    self.spread_in_block(key, function, body);
                    self.spread_in_block(key, function, continuing);
                }
                Statement::Store { pointer, value } if self.contains(key, *value) => {
                    match root(function, *pointer) {
                        Expression::LocalVariable(local) => {
                            self.locals.insert((key, *local));
                        }
                        Expression::GlobalVariable(global) => {
                            self.globals.insert(*global);
                        }
                        _ => {}
                    }
                }
                Statement::Call {
                    function: callee,
                    arguments,
                    ..
                } => {
                    for (i, &argument) in arguments.iter().enumerate() {
                        if self.contains(key, argument) {
                            self.arguments.insert((*callee, i as u32));
                        }
                    }
                }
                Statement::Return { value: Some(value) } if self.contains(key, *value) => {
                    if let Key::Function(handle) = key {
                        self.results.insert(handle);
                    }
                }
                _ => {}
            }
        }
    }

    /// Returns the liberty of an expression. `None` if it has none.
    fn liberty(
        &self,
        module: &Module,
        key: Key,
        function: &Function,
        info: &FunctionInfo,
        handle: Handle<Expression>,
        expression: &Expression,
    ) -> Option<Liberty> {
        let type_of = |handle: Handle<Expression>| info[handle].ty.inner_with(&module.types);
        let is_float = type_of(handle)
            .scalar()
            .is_some_and(|scalar| scalar.kind == ScalarKind::Float);
        if !is_float {
            return None;
        }
        match *expression {
            Expression::Binary { op, left, right } => {
                let is_matrix = |h| matches!(type_of(h), TypeInner::Matrix { .. });
                match op {
                    BinaryOperator::Add | BinaryOperator::Subtract => {
                        let fuses = self.contains(key, left) || self.contains(key, right);
                        fuses.then_some(Liberty::FusibleSum)
                    }
                    BinaryOperator::Multiply if is_matrix(left) || is_matrix(right) => {
                        Some(Liberty::FusibleBuiltIn("a product of a matrix".to_owned()))
                    }
                    // The reciprocal of a power of two is exact.
                    BinaryOperator::Divide if !is_power_of_two(module, function, right) => {
                        Some(Liberty::Quotient)
                    }
                    _ => None,
                }
            }
            Expression::Math { fun, .. } => match fun {
                MathFunction::Sqrt | MathFunction::InverseSqrt => Some(Liberty::Root),
                MathFunction::Abs
                | MathFunction::Min
                | MathFunction::Max
                | MathFunction::Clamp
                | MathFunction::Saturate
                | MathFunction::Ceil
                | MathFunction::Floor
                | MathFunction::Round
                | MathFunction::Trunc
                | MathFunction::Sign => None,
                other => Some(Liberty::FusibleBuiltIn(
                    format!("`{other:?}`").to_lowercase(),
                )),
            },
            _ => None,
        }
    }
}

/// Returns the variable behind a pointer.
fn root(function: &Function, mut pointer: Handle<Expression>) -> &Expression {
    loop {
        match function.expressions[pointer] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
                pointer = base;
            }
            ref other => return other,
        }
    }
}

/// Reports whether an expression is a constant power of two. Products with it are exact, and fusing
/// them changes nothing.
fn is_power_of_two(module: &Module, function: &Function, handle: Handle<Expression>) -> bool {
    let is_power = |literal: &Literal| match *literal {
        Literal::F32(x) => x.is_normal() && x.to_bits() & 0x007f_ffff == 0,
        _ => false,
    };
    match function.expressions[handle] {
        Expression::Literal(ref literal) => is_power(literal),
        Expression::Splat { value, .. } => is_power_of_two(module, function, value),
        Expression::Constant(constant) => {
            match module.global_expressions[module.constants[constant].init] {
                Expression::Literal(ref literal) => is_power(literal),
                _ => false,
            }
        }
        _ => false,
    }
}
