// A reader of SPIR-V modules: one pass over the instructions (SPIR-V 1.6 specification, section 2.3
// "Physical Layout of a SPIR-V Module and Instruction").
#include "gpu/reflection.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

namespace tetrec {
namespace {

using Words = std::span<const uint32_t>;

constexpr uint32_t kMagic = 0x07230203;
constexpr uint32_t kHeaderWords = 5;
constexpr uint32_t kMostIds = 1u << 22;  // the specification's limit on the bound

// Numbers of the SPIR-V specification, sections 3.6 to 3.52.
enum Op : uint32_t {
  kOpName = 5,
  kOpEntryPoint = 15,
  kOpExecutionMode = 16,
  kOpTypeInt = 21,
  kOpTypeFloat = 22,
  kOpTypeVector = 23,
  kOpTypeImage = 25,
  kOpTypeStruct = 30,
  kOpTypePointer = 32,
  kOpConstant = 43,
  kOpFunction = 54,
  kOpFunctionCall = 57,
  kOpVariable = 59,
  kOpLoad = 61,
  kOpAccessChain = 65,
  kOpInBoundsAccessChain = 66,
  kOpPtrAccessChain = 67,
  kOpArrayLength = 68,
  kOpDecorate = 71,
  kOpMemberDecorate = 72,
  kOpCopyObject = 83,
  kOpExecutionModeId = 331,
};
enum ExecutionMode : uint32_t { kLocalSize = 17, kLocalSizeId = 38 };
enum StorageClass : uint32_t {
  kUniformConstant = 0,
  kUniform = 2,
  kPushConstant = 9,
  kStorageBuffer = 12,
};
enum Decoration : uint32_t {
  kSpecId = 1,
  kNonWritable = 24,
  kNonReadable = 25,
  kBinding = 33,
  kDescriptorSet = 34,
  kOffset = 35,
};
constexpr uint32_t kDimBuffer = 5;

struct Decorations {
  std::optional<uint32_t> spec_id, binding, set, offset;
  bool non_writable = false, non_readable = false;
};

struct Type {
  uint32_t op = 0;
  uint32_t bytes = 0;             // 0: not known, which only matters in push constants
  uint32_t target = 0;            // of a pointer
  uint32_t dimension = 0;         // of an image
  bool is_sampled = false;        // of an image
  std::vector<uint32_t> members;  // of a struct
};

struct Variable {
  uint32_t id, pointer, storage;
};

class Reader {
 public:
  Reader(const std::string& name, Words words) : name_(name), words_(words) {}

  Reflection Read() {
    Check(words_.size() >= kHeaderWords && words_[0] == kMagic, "is not SPIR-V");
    bound_ = words_[3];
    Check(bound_ > 0 && bound_ <= kMostIds, fmt::format("bound of ids {}", bound_));
    for (size_t i = kHeaderWords; i < words_.size();) {
      const uint32_t count = words_[i] >> 16;
      at_ = i;
      if (count == 0 || count > words_.size() - i) Fail(fmt::format("is cut off at word {}", i));
      ReadInstruction(words_[i] & 0xFFFF, words_.subspan(i + 1, count - 1));
      i += count;
    }
    Check(entry_points_ == 1, fmt::format("{} entry points; expected 1", entry_points_));
    return Collect();
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw BugError(fmt::format("kernel {}: {}", name_, what));
  }
  void Check(bool condition, const std::string& what) const {
    if (!condition) Fail(what);
  }
  // Operands from number `i` on.
  Words From(Words operands, size_t i) const {
    if (i > operands.size()) Fail(fmt::format("the instruction at word {} is too short", at_));
    return operands.subspan(i);
  }
  uint32_t Word(Words operands, size_t i) const {
    if (i >= operands.size()) Fail(fmt::format("the instruction at word {} is too short", at_));
    return operands[i];
  }
  uint32_t Id(Words operands, size_t i) const {
    const uint32_t id = Word(operands, i);
    if (id == 0 || id >= bound_) Fail(fmt::format("word {}: id {} of {}", at_, id, bound_));
    return id;
  }

  void ReadInstruction(uint32_t op, Words operands) {
    switch (op) {
      case kOpName:
        names_[Id(operands, 0)] = Text(From(operands, 1));
        break;
      case kOpEntryPoint:
        Id(operands, 1);  // its function
        ++entry_points_;
        break;
      case kOpExecutionMode:
      case kOpExecutionModeId:
        ReadLocalSize(op, operands);
        break;
      case kOpDecorate:
        Decorate(decorations_[Id(operands, 0)], From(operands, 1));
        break;
      case kOpMemberDecorate:
        Decorate(member_decorations_[Id(operands, 0)][Word(operands, 1)], From(operands, 2));
        break;
      case kOpConstant:
        constants_[Id(operands, 1)] = Word(operands, 2);
        break;
      case kOpFunction:
        in_functions_ = true;
        break;
      case kOpVariable:
        // Those of functions are local.
        if (!in_functions_) {
          variables_.push_back({Id(operands, 1), Id(operands, 0), Word(operands, 2)});
        }
        break;
      default:
        in_functions_ ? ReadUse(op, operands) : ReadType(op, operands);
    }
  }

  // A string is packed 4 bytes to a word and ends with a 0.
  static std::string Text(Words words) {
    std::string text;
    for (const uint32_t word : words) {
      for (int shift = 0; shift < 32; shift += 8) {
        const char c = char(word >> shift & 0xFF);
        if (c == 0) return text;
        text += c;
      }
    }
    return text;
  }

  void ReadLocalSize(uint32_t op, Words operands) {
    const uint32_t mode = Word(operands, 1);
    const bool by_id = op == kOpExecutionModeId && mode == kLocalSizeId;
    if (!by_id && !(op == kOpExecutionMode && mode == kLocalSize)) return;
    local_size_is_ids_ = by_id;
    for (size_t i = 0; i < 3; ++i) {
      local_size_[i] = by_id ? Id(operands, 2 + i) : Word(operands, 2 + i);
    }
  }

  void Decorate(Decorations& decorations, Words words) {
    switch (Word(words, 0)) {
      case kSpecId:
        decorations.spec_id = Word(words, 1);
        break;
      case kNonWritable:
        decorations.non_writable = true;
        break;
      case kNonReadable:
        decorations.non_readable = true;
        break;
      case kBinding:
        decorations.binding = Word(words, 1);
        break;
      case kDescriptorSet:
        decorations.set = Word(words, 1);
        break;
      case kOffset:
        decorations.offset = Word(words, 1);
        break;
      default:
        break;
    }
  }

  // Types come after the decorations of their members and after the types that they are made of.
  void ReadType(uint32_t op, Words operands) {
    Type type{.op = op};
    switch (op) {
      case kOpTypeInt:
      case kOpTypeFloat:
        type.bytes = Word(operands, 1) / 8;
        break;
      case kOpTypeVector:
        type.bytes = Bytes(Id(operands, 1)) * std::min(Word(operands, 2), 4u);
        break;
      case kOpTypeImage:
        type.dimension = Word(operands, 2);
        type.is_sampled = Word(operands, 6) == 1;  // 2: a storage image
        break;
      case kOpTypeStruct:
        for (size_t i = 1; i < operands.size(); ++i) type.members.push_back(Id(operands, i));
        type.bytes = StructBytes(Id(operands, 0), type.members);
        break;
      case kOpTypePointer:
        type.target = Id(operands, 2);
        break;
      default:
        return;
    }
    types_[Id(operands, 0)] = type;
  }

  uint32_t Bytes(uint32_t type) const {
    const auto found = types_.find(type);
    return found == types_.end() ? 0 : found->second.bytes;
  }

  // To the end of the last member; 0 if a member's size or place is not known.
  uint32_t StructBytes(uint32_t id, const std::vector<uint32_t>& members) const {
    const auto decorated = member_decorations_.find(id);
    if (decorated == member_decorations_.end()) return 0;
    uint64_t end = 0;
    for (uint32_t i = 0; i < members.size(); ++i) {
      const auto member = decorated->second.find(i);
      const uint32_t bytes = Bytes(members[i]);
      if (bytes == 0 || member == decorated->second.end() || !member->second.offset) return 0;
      end = std::max(end, uint64_t(*member->second.offset) + bytes);
    }
    return end > UINT32_MAX ? 0 : uint32_t(end);
  }

  // Global variables are reached through these instructions only: blocks by access chains, texel
  // buffers by loads, either as an argument of a function.
  void ReadUse(uint32_t op, Words operands) {
    switch (op) {
      case kOpLoad:
      case kOpAccessChain:
      case kOpInBoundsAccessChain:
      case kOpPtrAccessChain:
      case kOpArrayLength:
      case kOpCopyObject:
        used_.push_back(Id(operands, 2));
        break;
      case kOpFunctionCall:
        for (size_t i = 3; i < operands.size(); ++i) used_.push_back(Id(operands, i));
        break;
      default:
        break;
    }
  }

  Reflection Collect() {
    std::sort(used_.begin(), used_.end());
    Reflection result;
    for (const Variable& variable : variables_) {
      switch (variable.storage) {
        case kPushConstant:
          Check(result.push_bytes == 0, "two blocks of push constants");
          result.push_bytes = Bytes(TargetOf(variable));
          Check(result.push_bytes > 0, "push constants other than scalars, vectors and structs");
          break;
        case kUniformConstant:
        case kUniform:
        case kStorageBuffer:
          result.bindings.push_back(BindingOf(variable));
          break;
        default:  // builtins, shared memory
          break;
      }
    }
    std::sort(result.bindings.begin(), result.bindings.end(),
              [](const KernelBinding& a, const KernelBinding& b) { return a.number < b.number; });
    for (size_t i = 1; i < result.bindings.size(); ++i) {
      Check(result.bindings[i - 1].number != result.bindings[i].number,
            fmt::format("two variables have binding {}", result.bindings[i].number));
    }
    for (const auto& [id, decorations] : decorations_) {
      if (decorations.spec_id) result.constant_ids.push_back(*decorations.spec_id);
    }
    std::sort(result.constant_ids.begin(), result.constant_ids.end());
    for (size_t i = 0; i < 3; ++i) {
      result.local_size[i] = local_size_is_ids_ ? ConstantOf(local_size_[i]) : local_size_[i];
    }
    return result;
  }

  uint32_t TargetOf(const Variable& variable) const {
    const auto pointer = types_.find(variable.pointer);
    Check(pointer != types_.end() && pointer->second.op == kOpTypePointer,
          fmt::format("variable {} has no pointer type", variable.id));
    return pointer->second.target;
  }

  uint32_t ConstantOf(uint32_t id) const {
    const auto found = constants_.find(id);
    Check(found != constants_.end(), "the local size is not constant");
    return found->second;
  }

  KernelBinding BindingOf(const Variable& variable) const {
    const uint32_t target = TargetOf(variable);
    const auto own = decorations_.find(variable.id);
    Check(own != decorations_.end() && own->second.binding && own->second.set.value_or(0) == 0,
          fmt::format("variable {} has no binding in set 0", variable.id));
    KernelBinding binding{.number = *own->second.binding,
                          .is_used = std::binary_search(used_.begin(), used_.end(), variable.id)};
    // A block without an instance name has its own name only.
    for (const uint32_t id : {variable.id, target}) {
      const auto found = names_.find(id);
      if (found != names_.end() && binding.name.empty()) binding.name = found->second;
    }
    const auto found = types_.find(target);
    const Type type = found == types_.end() ? Type{} : found->second;
    const bool is_texels = variable.storage == kUniformConstant && type.op == kOpTypeImage &&
                           type.dimension == kDimBuffer && type.is_sampled;
    const bool is_block = variable.storage == kStorageBuffer && type.op == kOpTypeStruct;
    Check(is_texels || is_block,
          fmt::format("binding {} ({}) is neither a storage buffer nor a texel buffer",
                      binding.number, binding.name));
    binding.access = is_texels ? Access::kTexelRead : AccessOf(own->second, target, type);
    return binding;
  }

  // By qualifiers of the variable or of all members of its block.
  Access AccessOf(const Decorations& own, uint32_t target, const Type& type) const {
    bool readonly = !type.members.empty(), writeonly = readonly;
    const auto decorated = member_decorations_.find(target);
    for (uint32_t i = 0; i < type.members.size(); ++i) {
      const Decorations* member = nullptr;
      if (decorated != member_decorations_.end() && decorated->second.contains(i)) {
        member = &decorated->second.at(i);
      }
      readonly = readonly && member != nullptr && member->non_writable;
      writeonly = writeonly && member != nullptr && member->non_readable;
    }
    if (readonly || own.non_writable) return Access::kRead;
    if (writeonly || own.non_readable) return Access::kWrite;
    return Access::kReadWrite;
  }

  const std::string& name_;
  const Words words_;
  uint32_t bound_ = 0;
  size_t at_ = 0;  // word of the instruction that is read
  uint32_t entry_points_ = 0;
  bool in_functions_ = false;
  std::array<uint32_t, 3> local_size_{};
  bool local_size_is_ids_ = false;
  std::map<uint32_t, std::string> names_;
  std::map<uint32_t, Decorations> decorations_;
  std::map<uint32_t, std::map<uint32_t, Decorations>> member_decorations_;
  std::map<uint32_t, Type> types_;
  std::map<uint32_t, uint32_t> constants_;
  std::vector<Variable> variables_;
  std::vector<uint32_t> used_;
};

}  // namespace

Reflection Reflect(const std::string& name, std::span<const uint32_t> spirv) {
  return Reader(name, spirv).Read();
}

Reflection Merge(const std::string& name, const Reflection& a, const Reflection& b) {
  Reflection both = a;
  both.push_bytes = std::max(a.push_bytes, b.push_bytes);
  for (const KernelBinding& more : b.bindings) {
    const auto place =
        std::find_if(both.bindings.begin(), both.bindings.end(),
                     [&](const KernelBinding& x) { return x.number >= more.number; });
    if (place == both.bindings.end() || place->number != more.number) {
      both.bindings.insert(place, more);
      continue;
    }
    const bool a_is_texels = place->access == Access::kTexelRead;
    if (a_is_texels != (more.access == Access::kTexelRead)) {
      throw BugError(fmt::format("kernel {}: its stages disagree on binding {} ({})", name,
                                 more.number, more.name));
    }
    if (place->access != more.access) place->access = Access::kReadWrite;
    place->is_used |= more.is_used;
  }
  for (const uint32_t id : b.constant_ids) {
    const auto place = std::lower_bound(both.constant_ids.begin(), both.constant_ids.end(), id);
    if (place == both.constant_ids.end() || *place != id) both.constant_ids.insert(place, id);
  }
  return both;
}

}  // namespace tetrec
