// Methods whose compiled twin is asked first: where it answers, Python makes no frame. As a method of Python's that
// asks the twin, `is_valid` takes 18 to 30 % longer and `check_motion` 11 to 13 % (Panda, UR5, Talos).
//
// In: a function of Python's; the slot (of `__slots__`) in which each object keeps its twin; how many arguments the
// twin takes from the call, and values for those after them. Out: a descriptor, to be kept in the class in the
// function's place. A call with so many positional arguments, none of them None, asks the twin; where there is none, or
// it answers None, and for any other call, the function is called. All else (name, documentation, signature, pickles of
// bound methods) is the function's.
//
// The twin is the object's and not the descriptor's, so there are no cycles, and copies and pickles of an object say
// themselves what they keep. It is in a slot, whose place in the object the class knows: looking it up in the object's
// dictionary took a twentieth of a single state. nanobind's own classes have no vector calls of this kind: hence
// Python's interface.
#include <nanobind/nanobind.h>
#include <structmember.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "bindings/module.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

// Most arguments of a twin, the descriptor's own included.
constexpr Py_ssize_t kMostArguments = 4;

struct CompiledFirst {
  PyObject_HEAD vectorcallfunc call;
  PyObject *function, *slot, *values;
  Py_ssize_t arguments;
  PyTypeObject* owner;  // the class whose slot it is; null as long as there is none
  Py_ssize_t place;     // of the slot within its objects
  PyObject* weak_references;
};

CompiledFirst* of(PyObject* self) { return reinterpret_cast<CompiledFirst*>(self); }

// A new reference; null where the object keeps none.
PyObject* twin_of(PyObject* object, const CompiledFirst& method) {
  if (method.owner == nullptr || !PyObject_TypeCheck(object, method.owner)) return nullptr;
  return Py_XNewRef(*reinterpret_cast<PyObject**>(reinterpret_cast<char*>(object) + method.place));
}

// What the twin of args[0] answers to the arguments after it; None where that is the function's to say.
PyObject* answer_of_twin(const CompiledFirst& method, PyObject* const* args) {
  PyObject* const twin = twin_of(args[0], method);
  if (twin == nullptr) Py_RETURN_NONE;
  if (twin == Py_None) return twin;
  std::array<PyObject*, kMostArguments> given;
  std::copy_n(args + 1, method.arguments, given.begin());
  const Py_ssize_t values = PyTuple_GET_SIZE(method.values);
  for (Py_ssize_t k = 0; k < values; ++k)
    given[static_cast<std::size_t>(method.arguments + k)] = PyTuple_GET_ITEM(method.values, k);
  PyObject* const answer =
      PyObject_Vectorcall(twin, given.data(), static_cast<std::size_t>(method.arguments + values), nullptr);
  Py_DECREF(twin);
  return answer;
}

PyObject* call(PyObject* self, PyObject* const* args, std::size_t count, PyObject* names) {
  const CompiledFirst& method = *of(self);
  const Py_ssize_t given = PyVectorcall_NARGS(count);
  const bool is_for_twin = names == nullptr && given == 1 + method.arguments;
  if (is_for_twin && std::find(args, args + given, Py_None) == args + given) {
    PyObject* const answer = answer_of_twin(method, args);
    if (answer != Py_None) return answer;
    Py_DECREF(answer);
  }
  return PyObject_Vectorcall(method.function, args, count, names);
}

PyObject* make(PyTypeObject* type, PyObject* args, PyObject* names) {
  static const char* const kNames[] = {"function", "slot", "arguments", "values", nullptr};
  PyObject *function, *slot, *values;
  Py_ssize_t arguments;
  if (!PyArg_ParseTupleAndKeywords(args, names, "OUnO!", const_cast<char**>(kNames), &function, &slot, &arguments,
                                   &PyTuple_Type, &values)) {
    return nullptr;
  }
  if (arguments < 0 || arguments > kMostArguments - PyTuple_GET_SIZE(values)) {
    PyErr_Format(PyExc_ValueError, "a compiled twin takes at most %zd arguments", kMostArguments);
    return nullptr;
  }
  PyObject* const self = type->tp_alloc(type, 0);
  if (self == nullptr) return nullptr;
  CompiledFirst& method = *of(self);
  method.call = &call;
  method.function = Py_NewRef(function), method.slot = Py_NewRef(slot), method.values = Py_NewRef(values);
  method.arguments = arguments;
  return self;
}

// Python calls this with the class and the name that the method has there. In another class that takes it over, it is
// the function alone, unless that class inherits from the first.
PyObject* set_name(PyObject* self, PyObject* args) {
  PyTypeObject* owner;
  PyObject* name;
  if (!PyArg_ParseTuple(args, "O!U", &PyType_Type, &owner, &name)) return nullptr;
  CompiledFirst& method = *of(self);
  if (method.owner != nullptr) Py_RETURN_NONE;
  PyObject* const slot = PyObject_GetAttr(reinterpret_cast<PyObject*>(owner), method.slot);
  if (slot == nullptr) PyErr_Clear();
  const bool is_slot = slot != nullptr && Py_TYPE(slot) == &PyMemberDescr_Type &&
                       PyType_IsSubtype(owner, PyDescr_TYPE(slot)) != 0 &&
                       reinterpret_cast<PyMemberDescrObject*>(slot)->d_member->type == T_OBJECT_EX;
  if (is_slot) method.place = reinterpret_cast<PyMemberDescrObject*>(slot)->d_member->offset;
  Py_XDECREF(slot);
  if (!is_slot) {
    PyErr_Format(PyExc_TypeError, "%U of class %s has its compiled twin in %R, which must be one of its __slots__",
                 name, owner->tp_name, method.slot);
    return nullptr;
  }
  Py_INCREF(owner);
  method.owner = owner;
  Py_RETURN_NONE;
}

int traverse(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(of(self)->function);
  Py_VISIT(of(self)->values);
  Py_VISIT(of(self)->owner);
  Py_VISIT(Py_TYPE(self));
  return 0;
}

int clear(PyObject* self) {
  Py_CLEAR(of(self)->function);
  Py_CLEAR(of(self)->slot);
  Py_CLEAR(of(self)->values);
  Py_CLEAR(of(self)->owner);
  return 0;
}

void dealloc(PyObject* self) {
  PyTypeObject* const type = Py_TYPE(self);
  PyObject_GC_UnTrack(self);
  if (of(self)->weak_references != nullptr) PyObject_ClearWeakRefs(self);
  clear(self);
  type->tp_free(self);
  Py_DECREF(type);
}

PyObject* bound_to(PyObject* self, PyObject* object, PyObject*) {
  return object == nullptr ? Py_NewRef(self) : PyMethod_New(self, object);
}

// The function's attributes, for all that asks a method what it is, but for pickles, which go by its name.
PyObject* attribute_of(PyObject* self, PyObject* name) {
  const auto is = [&](const char* other) { return PyUnicode_CompareWithASCIIString(name, other) == 0; };
  if (is("__wrapped__")) return Py_NewRef(of(self)->function);
  if (is("__reduce__") || is("__reduce_ex__")) return PyObject_GenericGetAttr(self, name);
  return PyObject_GetAttr(of(self)->function, name);
}

// Some ask for it as if it were any object's.
PyObject* documentation(PyObject* self, void*) { return PyObject_GetAttrString(of(self)->function, "__doc__"); }

PyObject* described(PyObject* self) { return PyObject_Repr(of(self)->function); }

PyObject* reduced(PyObject* self, PyObject*) { return PyObject_GetAttrString(of(self)->function, "__qualname__"); }

PyGetSetDef properties[] = {{"__doc__", &documentation, nullptr, nullptr, nullptr},
                            {nullptr, nullptr, nullptr, nullptr, nullptr}};

PyMethodDef methods[] = {{"__reduce__", &reduced, METH_NOARGS, nullptr},
                         {"__set_name__", &set_name, METH_VARARGS, nullptr},
                         {nullptr, nullptr, 0, nullptr}};

PyMemberDef members[] = {
    {"__vectorcalloffset__", T_PYSSIZET, offsetof(CompiledFirst, call), READONLY, nullptr},
    {"__weaklistoffset__", T_PYSSIZET, offsetof(CompiledFirst, weak_references), READONLY, nullptr},
    {nullptr, 0, 0, 0, nullptr}};

template <class Function>
void* slot(Function* function) {
  return reinterpret_cast<void*>(function);
}

}  // namespace

void bind_compiled_first(nb::module_& m) {
  static PyType_Slot slots[] = {{Py_tp_new, slot(&make)},
                                {Py_tp_dealloc, slot(&dealloc)},
                                {Py_tp_traverse, slot(&traverse)},
                                {Py_tp_clear, slot(&clear)},
                                {Py_tp_call, slot(&PyVectorcall_Call)},
                                {Py_tp_repr, slot(&described)},
                                {Py_tp_descr_get, slot(&bound_to)},
                                {Py_tp_getattro, slot(&attribute_of)},
                                {Py_tp_members, members},
                                {Py_tp_methods, methods},
                                {Py_tp_getset, properties},
                                {0, nullptr}};
  static PyType_Spec spec{"plannercheck.CompiledFirst", sizeof(CompiledFirst), 0,
                          Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_HAVE_VECTORCALL |
                              Py_TPFLAGS_METHOD_DESCRIPTOR | Py_TPFLAGS_IMMUTABLETYPE,
                          slots};
  m.attr("CompiledFirst") = nb::steal(PyType_FromSpec(&spec));
}

}  // namespace plannercheck
