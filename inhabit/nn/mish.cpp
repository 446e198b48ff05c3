#include "inhabit/nn/mish.h"

#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>

#include "inhabit/nn/mish_kernel.h"

namespace inhabit::nn {

using torch::Tensor;

namespace {

constexpr int64_t kGrain = 16384;  // numbers a thread takes at least

struct Mish : torch::autograd::Function<Mish> {
  static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& input) {
    const Tensor x = input.contiguous(), y = torch::empty_like(x);
    context->save_for_backward({x});
    at::parallel_for(0, x.numel(), kGrain, [&](int64_t begin, int64_t end) {
      mish_forward(x.data_ptr<float>() + begin, end - begin, y.data_ptr<float>() + begin);
    });
    return y;
  }
  static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                               torch::autograd::tensor_list gradients) {
    const Tensor x = context->get_saved_variables()[0], gradient = gradients[0].contiguous(),
                 out = torch::empty_like(x);
    at::parallel_for(0, x.numel(), kGrain, [&](int64_t begin, int64_t end) {
      mish_backward(x.data_ptr<float>() + begin, gradient.data_ptr<float>() + begin, end - begin,
                    out.data_ptr<float>() + begin);
    });
    return {out};
  }
};

}  // namespace

Tensor mish(const Tensor& x) {
  const Tensor single = x.to(torch::kFloat32);
  return single.is_cpu() ? Mish::apply(single) : torch::mish(single);
}

}  // namespace inhabit::nn
