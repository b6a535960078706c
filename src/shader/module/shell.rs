//! An entry point that calls functions, so that they do not count as unused.

use naga::{EntryPoint, Expression, Handle, ShaderStage, Span, Statement};

/// A fragment shader without inputs and outputs that calls each function with zeros as arguments.
pub fn shell(
    ir: &naga::Module,
    name: &str,
    functions: impl Iterator<Item = Handle<naga::Function>>,
) -> EntryPoint {
    let mut function = naga::Function::default();
    for handle in functions {
        let arguments = ir.functions[handle].arguments.iter().map(|argument| {
            let zero = Expression::ZeroValue(argument.ty);
            function.expressions.append(zero, Span::UNDEFINED)
        });
        let arguments = arguments.collect();
        let result = ir.functions[handle]
            .result
            .as_ref()
            .map(|_| function.expressions.append(Expression::CallResult(handle), Span::UNDEFINED));
        let call = Statement::Call { function: handle, arguments, result };
        function.body.push(call, Span::UNDEFINED);
    }
    function.body.push(Statement::Return { value: None }, Span::UNDEFINED);
    EntryPoint {
        name: name.to_owned(),
        stage: ShaderStage::Fragment,
        early_depth_test: None,
        workgroup_size: [0; 3],
        workgroup_size_overrides: None,
        function,
        mesh_info: None,
        task_payload: None,
        incoming_ray_payload: None,
    }
}
