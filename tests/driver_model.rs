//! Models of drivers with different rounding, implemented by rewriting shaders.
//!
//! WGSL permits drivers to fuse products with sums, to re-associate sums, and to return quotients
//! with an error of 2.5 units in the last place, and roots with that of `1 / inverseSqrt(x)`: 4.5
//! units. The software drivers of CI do none of this, and cards do. Each shader text is therefore
//! parsed, rewritten to compute the result of such a driver, and written as WGSL again.

use naga::{
    Arena, BinaryOperator, Block, Expression, Function, Handle, Literal, MathFunction, Module,
    Range, Scalar, ScalarKind, Span, Statement, SwitchCase, TypeInner, VectorSize,
    back::wgsl::{WriterFlags, write_string},
    front::wgsl::parse_str,
    valid::{Capabilities, FunctionInfo, ValidationFlags, Validator},
};
use std::{env, str::FromStr};
use umbrage_wgpu::ShaderRewriter;

/// Environment variable with the model that all devices of a test program follow.
pub const VARIABLE: &str = "UMBRAGE_DRIVER_MODEL";

/// Environment variable that makes tests of many cases run every Nth of them: an integer, 1 or
/// more.
pub const NTH_VARIABLE: &str = "UMBRAGE_EVERY_NTH_CASE";

/// Returns the N of "every Nth case", by default 1.
///
/// # Panics
/// Panics if the environment variable is not such a number.
pub fn nth_case() -> usize {
    let Ok(text) = env::var(NTH_VARIABLE) else {
        return 1;
    };
    match text.parse() {
        Ok(nth) if nth > 0 => nth,
        _ => panic!("{NTH_VARIABLE} is `{text}`: set it to a whole number, 1 or more"),
    }
}

/// Reports whether tests run all their cases.
pub fn runs_all_cases() -> bool {
    nth_case() == 1
}

/// Reports whether the case with this number runs.
pub fn is_chosen(case: usize) -> bool {
    case.is_multiple_of(nth_case())
}

/// Rounding behaviour of a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverModel {
    /// Rounds `a * b + c`, `a * b - c` and `c - a * b` once. Computed in 64 bits, since software
    /// drivers have no fused instruction.
    Fused,
    /// Adds `a + b + c` from right to left.
    Reassociated,
    /// Returns quotients with an error of 1 or 2 units in the last place, and square roots with one
    /// of 2 or 4.
    Inaccurate,
}

impl FromStr for DriverModel {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "fused" => Ok(Self::Fused),
            "reassociated" => Ok(Self::Reassociated),
            "inaccurate" => Ok(Self::Inaccurate),
            _ => Err(format!(
                "{VARIABLE} is `{name}`: set it to `fused`, `reassociated` or `inaccurate`, or leave it unset"
            )),
        }
    }
}

impl DriverModel {
    /// Returns the model of the environment variable. `None` if it is not set.
    ///
    /// # Panics
    /// Panics if there is no model of that name.
    pub fn from_env() -> Option<Self> {
        let name = env::var(VARIABLE).ok()?;
        Some(name.parse().unwrap_or_else(|why: String| panic!("{why}")))
    }

    /// Makes all shaders of the process follow the model of the environment variable, if it is set.
    /// Returns that model.
    ///
    /// # Panics
    /// Panics if there is no model of that name.
    pub fn install() -> Option<Self> {
        let model = Self::from_env()?;
        umbrage_wgpu::rewrite_shaders(ShaderRewriter {
            rewrite: match model {
                Self::Fused => |text| Self::Fused.rewrite(text),
                Self::Reassociated => |text| Self::Reassociated.rewrite(text),
                Self::Inaccurate => |text| Self::Inaccurate.rewrite(text),
            },
            features: model.features(),
        });
        Some(model)
    }

    /// Returns the device features that rewritten shaders need.
    pub fn features(self) -> wgpu::Features {
        match self {
            Self::Fused => wgpu::Features::SHADER_F64,
            Self::Reassociated | Self::Inaccurate => wgpu::Features::empty(),
        }
    }

    /// Returns a shader that computes the results of such a driver for `wgsl`.
    ///
    /// # Panics
    /// Panics if the text has a kind of statement that no shader here has. Text that is not valid
    /// WGSL is returned unchanged.
    pub fn rewrite(self, wgsl: &str) -> String {
        let Ok(mut module) = parse_str(wgsl) else {
            return wgsl.to_owned();
        };
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
        let info = validator.validate(&module).expect("valid WGSL");
        let original = module.clone();
        for (handle, function) in module.functions.iter_mut() {
            *function = Rewriter::new(self, &original, function, &info[handle]).finish(function);
        }
        for (i, entry) in module.entry_points.iter_mut().enumerate() {
            let info = info.get_entry_point(i);
            entry.function =
                Rewriter::new(self, &original, &entry.function, info).finish(&entry.function);
        }
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(&module)
            .unwrap_or_else(|e| panic!("{self:?}: {}", e.emit_to_string(wgsl)));
        write_string(&module, &info, WriterFlags::empty()).expect("valid modules can be written")
    }
}

/// Literals for rewritten expressions. They can't be created in the middle of a block.
struct Literals {
    one: Handle<Expression>,
    two: Handle<Expression>,
    three: Handle<Expression>,
    exponent: Handle<Expression>,
    zero: Handle<Expression>,
}

impl Literals {
    fn new(out: &mut Arena<Expression>) -> Self {
        let mut literal =
            |value| out.append(Expression::Literal(Literal::U32(value)), Span::UNDEFINED);
        Self {
            one: literal(1),
            two: literal(2),
            three: literal(3),
            exponent: literal(0x7f80_0000),
            zero: literal(0),
        }
    }
}

/// Rewrites a function's expressions.
struct Rewriter<'a> {
    model: DriverModel,
    module: &'a Module,
    old: &'a Function,
    info: &'a FunctionInfo,
    new: Arena<Expression>,
    literals: Literals,
    /// The first of the expressions created for each old one, and its replacement.
    made: Vec<(Handle<Expression>, Handle<Expression>)>,
}

impl<'a> Rewriter<'a> {
    fn new(
        model: DriverModel,
        module: &'a Module,
        old: &'a Function,
        info: &'a FunctionInfo,
    ) -> Self {
        let mut new = Arena::new();
        let literals = Literals::new(&mut new);
        Self {
            model,
            module,
            old,
            info,
            new,
            literals,
            made: Vec::with_capacity(old.expressions.len()),
        }
    }

    fn finish(mut self, function: &Function) -> Function {
        for (handle, expression) in self.old.expressions.iter() {
            let before = self.new.len();
            let stands_for_it = self.rewrite_expression(handle, expression);
            let first = self
                .new
                .iter()
                .nth(before)
                .map_or(stands_for_it, |(handle, _)| handle);
            self.made.push((first, stands_for_it));
        }
        let mut out = function.clone();
        for (_, local) in out.local_variables.iter_mut() {
            local.init = local.init.map(|init| self.replacement_of(init));
        }
        out.named_expressions = function
            .named_expressions
            .iter()
            .map(|(&handle, name)| (self.replacement_of(handle), name.clone()))
            .collect();
        self.block(&mut out.body);
        out.expressions = self.new;
        out
    }

    /// Returns the replacement of an old expression.
    fn replacement_of(&self, old: Handle<Expression>) -> Handle<Expression> {
        self.made[old.index()].1
    }

    fn push(&mut self, expression: Expression) -> Handle<Expression> {
        self.new.append(expression, Span::UNDEFINED)
    }

    fn binary(
        &mut self,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Handle<Expression> {
        self.push(Expression::Binary { op, left, right })
    }

    /// Returns the number of components of an old expression of type f32. `None` if it has another
    /// type.
    fn float_size(&self, old: Handle<Expression>) -> Option<Option<VectorSize>> {
        match *self.info[old].ty.inner_with(&self.module.types) {
            TypeInner::Scalar(Scalar::F32) => Some(None),
            TypeInner::Vector {
                size,
                scalar: Scalar::F32,
            } => Some(Some(size)),
            _ => None,
        }
    }

    fn rewrite_expression(
        &mut self,
        handle: Handle<Expression>,
        old: &Expression,
    ) -> Handle<Expression> {
        let size = self.float_size(handle);
        if let (Some(size), model) = (size, self.model) {
            match (model, old) {
                (DriverModel::Fused, Expression::Binary { op, left, right }) => {
                    if let Some(fused) = self.fuse_multiply_add(*op, *left, *right) {
                        return fused;
                    }
                }
                (DriverModel::Reassociated, Expression::Binary { op, left, right }) => {
                    if let Some(sum) = self.reassociate_sum(*op, *left, *right) {
                        return sum;
                    }
                }
                (
                    DriverModel::Inaccurate,
                    Expression::Binary {
                        op: BinaryOperator::Divide,
                        left: operand,
                        ..
                    }
                    | Expression::Math {
                        fun: MathFunction::Sqrt | MathFunction::InverseSqrt,
                        arg: operand,
                        ..
                    },
                ) => {
                    let is_root = matches!(
                        old,
                        Expression::Math {
                            fun: MathFunction::Sqrt,
                            ..
                        }
                    );
                    let moves = if is_root { 2 } else { 1 };
                    let exact = self.copy_expression(old);
                    return self.move_by_units(exact, self.replacement_of(*operand), size, moves);
                }
                _ => {}
            }
        }
        self.copy_expression(old)
    }

    fn copy_expression(&mut self, old: &Expression) -> Handle<Expression> {
        let mut copy = old.clone();
        for_each_operand(&mut copy, |operand| {
            *operand = self.replacement_of(*operand)
        });
        self.push(copy)
    }

    /// Returns the factors if an old expression is a product of floats.
    fn factors(&self, old: Handle<Expression>) -> Option<[Handle<Expression>; 2]> {
        match self.old.expressions[old] {
            Expression::Binary {
                op: BinaryOperator::Multiply,
                left,
                right,
            } if self.float_size(left).is_some() && self.float_size(right).is_some() => {
                Some([left, right])
            }
            _ => None,
        }
    }

    /// Returns a sum or difference whose product is not rounded. `None` if it has no product.
    fn fuse_multiply_add(
        &mut self,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Option<Handle<Expression>> {
        if !matches!(op, BinaryOperator::Add | BinaryOperator::Subtract) {
            return None;
        }
        let exact_operand = |this: &mut Self, factors: [Handle<Expression>; 2]| {
            let [a, b] =
                factors.map(|factor| this.convert_to_width(this.replacement_of(factor), 8));
            this.binary(BinaryOperator::Multiply, a, b)
        };
        let [wide_left, wide_right] = if let Some(factors) = self.factors(left) {
            let product = exact_operand(self, factors);
            [
                product,
                self.convert_to_width(self.replacement_of(right), 8),
            ]
        } else if let Some(factors) = self.factors(right) {
            let product = exact_operand(self, factors);
            [self.convert_to_width(self.replacement_of(left), 8), product]
        } else {
            return None;
        };
        let sum = self.binary(op, wide_left, wide_right);
        Some(self.convert_to_width(sum, 4))
    }

    /// Converts a float to one of this number of bytes.
    fn convert_to_width(&mut self, expr: Handle<Expression>, bytes: u8) -> Handle<Expression> {
        self.push(Expression::As {
            expr,
            kind: ScalarKind::Float,
            convert: Some(bytes),
        })
    }

    /// Returns `a + (b + c)` for `(a + b) + c`, or `a + (b - c)`. `None` for other expressions.
    fn reassociate_sum(
        &mut self,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Option<Handle<Expression>> {
        if !matches!(op, BinaryOperator::Add | BinaryOperator::Subtract) {
            return None;
        }
        let Expression::Binary {
            op: BinaryOperator::Add,
            left: first,
            right: second,
        } = self.old.expressions[left]
        else {
            return None;
        };
        let (first, second, right) = (
            self.replacement_of(first),
            self.replacement_of(second),
            self.replacement_of(right),
        );
        let last = self.binary(op, second, right);
        Some(self.binary(BinaryOperator::Add, first, last))
    }

    /// Returns a number that differs by `moves` times 1 or 2 units in the last place; 0 and
    /// non-finite numbers stay unchanged. The direction and size depend on the number of 1 bits of
    /// the operand, so that quotients that are powers of 2 are changed in both directions.
    fn move_by_units(
        &mut self,
        exact: Handle<Expression>,
        operand: Handle<Expression>,
        size: Option<VectorSize>,
        moves: usize,
    ) -> Handle<Expression> {
        let splat = |this: &mut Self, literal| match size {
            Some(size) => this.push(Expression::Splat {
                size,
                value: literal,
            }),
            None => literal,
        };
        let one = splat(self, self.literals.one);
        let two = splat(self, self.literals.two);
        let three = splat(self, self.literals.three);
        let exponent_mask = splat(self, self.literals.exponent);
        let zero = splat(self, self.literals.zero);
        let [bits, operand_bits] = [exact, operand].map(|expr| {
            self.push(Expression::As {
                expr,
                kind: ScalarKind::Uint,
                convert: None,
            })
        });
        let count = self.push(Expression::Math {
            fun: MathFunction::CountOneBits,
            arg: operand_bits,
            arg1: None,
            arg2: None,
            arg3: None,
        });
        // 0, 1, 2 and 3 become -2, -1, 1 and 2.
        let rank = self.binary(BinaryOperator::And, count, three);
        let half_rank = self.binary(BinaryOperator::ShiftRight, rank, one);
        let up = self.binary(BinaryOperator::Add, rank, half_rank);
        let mut moved_bits = bits;
        for _ in 0..moves {
            let down = self.binary(BinaryOperator::Subtract, moved_bits, two);
            moved_bits = self.binary(BinaryOperator::Add, down, up);
        }
        let exponent = self.binary(BinaryOperator::And, bits, exponent_mask);
        let is_small = self.binary(BinaryOperator::Equal, exponent, zero);
        let is_infinite = self.binary(BinaryOperator::Equal, exponent, exponent_mask);
        let reject = self.push(Expression::Select {
            condition: is_small,
            accept: bits,
            reject: moved_bits,
        });
        let kept = self.push(Expression::Select {
            condition: is_infinite,
            accept: bits,
            reject,
        });
        self.push(Expression::As {
            expr: kept,
            kind: ScalarKind::Float,
            convert: None,
        })
    }

    fn block(&self, block: &mut Block) {
        for statement in block.iter_mut() {
            self.statement(statement);
        }
    }

    fn statement(&self, statement: &mut Statement) {
        let replace = |handle: &mut Handle<Expression>| *handle = self.replacement_of(*handle);
        match statement {
            Statement::Emit(range) => {
                let mut emitted = range.clone();
                let first = emitted.next();
                let last = emitted.last().or(first);
                if let (Some(first), Some(last)) = (first, last) {
                    *range = Range::new_from_bounds(
                        self.made[first.index()].0,
                        self.replacement_of(last),
                    );
                }
            }
            Statement::Block(block) => self.block(block),
            Statement::If {
                condition,
                accept,
                reject,
            } => {
                replace(condition);
                self.block(accept);
                self.block(reject);
            }
            Statement::Switch { selector, cases } => {
                replace(selector);
                for SwitchCase { body, .. } in cases {
                    self.block(body);
                }
            }
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => {
                self.block(body);
                self.block(continuing);
                break_if.iter_mut().for_each(replace);
            }
            Statement::Return { value } => value.iter_mut().for_each(replace),
            Statement::Store { pointer, value } => [pointer, value].into_iter().for_each(replace),
            Statement::ImageStore {
                image,
                coordinate,
                array_index,
                value,
            } => {
                [image, coordinate, value].into_iter().for_each(replace);
                array_index.iter_mut().for_each(replace);
            }
            Statement::Atomic {
                pointer,
                value,
                result,
                ..
            } => {
                [pointer, value].into_iter().for_each(replace);
                result.iter_mut().for_each(replace);
            }
            Statement::WorkGroupUniformLoad { pointer, result } => {
                [pointer, result].into_iter().for_each(replace);
            }
            Statement::Call {
                arguments, result, ..
            } => {
                arguments.iter_mut().for_each(replace);
                result.iter_mut().for_each(replace);
            }
            Statement::Break
            | Statement::Continue
            | Statement::Kill
            | Statement::ControlBarrier(_)
            | Statement::MemoryBarrier(_) => {}
            other => panic!("no shader here has a statement like {other:?}"),
        }
    }
}

/// Calls `visit` with each operand of an expression.
fn for_each_operand(expression: &mut Expression, mut visit: impl FnMut(&mut Handle<Expression>)) {
    match expression {
        Expression::Literal(_)
        | Expression::Constant(_)
        | Expression::Override(_)
        | Expression::ZeroValue(_)
        | Expression::FunctionArgument(_)
        | Expression::GlobalVariable(_)
        | Expression::LocalVariable(_)
        | Expression::CallResult(_)
        | Expression::AtomicResult { .. }
        | Expression::WorkGroupUniformLoadResult { .. } => {}
        Expression::Compose { components, .. } => components.iter_mut().for_each(visit),
        Expression::Access { base, index } => [base, index].into_iter().for_each(visit),
        Expression::AccessIndex { base, .. } => visit(base),
        Expression::Splat { value, .. } => visit(value),
        Expression::Swizzle { vector, .. } => visit(vector),
        Expression::Load { pointer } => visit(pointer),
        Expression::ImageSample {
            image,
            sampler,
            coordinate,
            array_index,
            offset,
            level,
            depth_ref,
            ..
        } => {
            [image, sampler, coordinate]
                .into_iter()
                .for_each(&mut visit);
            [array_index, offset, depth_ref]
                .into_iter()
                .flatten()
                .for_each(&mut visit);
            match level {
                naga::SampleLevel::Exact(x) | naga::SampleLevel::Bias(x) => visit(x),
                naga::SampleLevel::Gradient { x, y } => [x, y].into_iter().for_each(visit),
                naga::SampleLevel::Auto | naga::SampleLevel::Zero => {}
            }
        }
        Expression::ImageLoad {
            image,
            coordinate,
            array_index,
            sample,
            level,
        } => {
            [image, coordinate].into_iter().for_each(&mut visit);
            [array_index, sample, level]
                .into_iter()
                .flatten()
                .for_each(visit);
        }
        Expression::ImageQuery { image, query } => {
            visit(image);
            if let naga::ImageQuery::Size { level: Some(level) } = query {
                visit(level);
            }
        }
        Expression::Unary { expr, .. }
        | Expression::Derivative { expr, .. }
        | Expression::As { expr, .. } => visit(expr),
        Expression::Binary { left, right, .. } => [left, right].into_iter().for_each(visit),
        Expression::Select {
            condition,
            accept,
            reject,
        } => [condition, accept, reject].into_iter().for_each(visit),
        Expression::Relational { argument, .. } => visit(argument),
        Expression::Math {
            arg,
            arg1,
            arg2,
            arg3,
            ..
        } => {
            visit(arg);
            [arg1, arg2, arg3].into_iter().flatten().for_each(visit);
        }
        Expression::ArrayLength(pointer) => visit(pointer),
        other => panic!("no shader here has an expression like {other:?}"),
    }
}
