#pragma once
#include <string>
#include <string_view>

#include "inhabit/io/pickle.h"

namespace inhabit {

/// Reads what torch.save of PyTorch before 1.6 writes, VPoser's weights among it: a pickle whose tensors' numbers come
/// after it. Tensors are arrays, on the CPU wherever they were; parameters and ordered dictionaries are plain ones.
/// Nothing is ever executed. Throws Error(subject, ...) for anything else that pickles refuse, and for the zip archives
/// of newer versions.
Pickle parse_torch(std::string_view bytes, const std::string& subject);

}  // namespace inhabit
