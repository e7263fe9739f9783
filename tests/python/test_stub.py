import ast
import inspect
import pathlib

import raygraph as rg

STUB = pathlib.Path(rg.__file__).resolve().with_name("__init__.pyi")


def stub_names():
    """Public names of the stub: of the module, and of each class those of its members."""
    names = {}
    for node in ast.parse(STUB.read_text()).body:
        if isinstance(node, ast.ClassDef):
            names[node.name] = {member.name if isinstance(member, ast.FunctionDef) else member.target.id
                                for member in node.body if not isinstance(member, ast.Expr)}
        elif isinstance(node, ast.FunctionDef):
            names[node.name] = set()
    return names


def test_stub_has_every_public_name_and_no_other():
    stub = stub_names()
    assert set(stub) == set(rg.__all__)
    for name, members in stub.items():
        of_module = getattr(rg, name)
        assert callable(of_module)
        if not inspect.isclass(of_module) or issubclass(of_module, Exception):
            continue
        public = {member for member in vars(of_module) if not member.startswith("_")}
        assert {member for member in members if not member.startswith("_")} == public, name


def test_stub_has_the_parameters_of_functions_in_python():
    for node in ast.parse(STUB.read_text()).body:
        if isinstance(node, ast.FunctionDef) and inspect.isfunction(getattr(rg, node.name)):
            arguments = [each.arg for each in node.args.args + node.args.kwonlyargs]
            expected = [parameter.name for parameter in inspect.signature(getattr(rg, node.name)).parameters.values()
                        if parameter.kind is not parameter.VAR_KEYWORD]
            assert arguments == expected, node.name


def test_every_public_name_has_a_docstring():
    for name in rg.__all__:
        assert getattr(rg, name).__doc__, name
