#include "inhabit/io/pickle.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "inhabit/io/atomic_file.h"
#include "inhabit/io/npy_format.h"
#include "inhabit/io/npz.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

std::string refused(const std::string& bytes) {
  return refusal_of([&] { parse_pickle(bytes, "x.pkl"); });
}

/// Runs Python with NumPy on a script that writes into `folder`; false where there is no such Python.
bool python(const TempFolder& folder, const std::string& script) {
  if (std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") != 0) return false;
  write_atomically(folder / "script.py", script);
  const std::string command = "cd '" + folder.path.string() + "' && /usr/bin/python3 script.py";
  EXPECT_EQ(std::system(command.c_str()), 0);
  return true;
}

// Text values only, so that one comparison shows all of them.
std::string shown(const PickleValue& value) {
  using Kind = PickleValue::Kind;
  std::string items;
  for (const PickleValue* item : value.items) items += shown(*item) + " ";
  switch (value.kind) {
    case Kind::none:
      return "None";
    case Kind::boolean:
      return value.boolean ? "True" : "False";
    case Kind::whole:
      return std::to_string(value.whole);
    case Kind::real:
      return std::to_string(value.real);
    case Kind::text:
      return "'" + value.text + "'";
    case Kind::bytes:
      return "b" + std::to_string(value.text.size());
    case Kind::list:
      return "[" + items + "]";
    case Kind::tuple:
      return "(" + items + ")";
    case Kind::set:
      return "set(" + items + ")";
    case Kind::dict:
      return "{" + items + "}";
    default:
      return "?";
  }
}

TEST(Pickle, ReadsWhatPythonWritesInEveryProtocol) {
  const TempFolder folder;
  const bool there = python(folder, R"(
import pickle, numpy as np
value = {'none': None, 'yes': True, 'no': False, 'small': 7, 'minus': -300, 'long': -2**40, 'real': 0.25,
         'text': 'l\u00e4nger\n\\', 'bytes': bytes(range(256)), 'list': [1, [2, ()], (3,), (4, 5), (6, 7, 8, 9)],
         'set': {5}, 'frozen': frozenset([6]), 'doubles': np.arange(12.0).reshape(3, 4) / 8,
         'fortran': np.asfortranarray(np.arange(6, dtype='f4').reshape(2, 3)), 'big': np.arange(3, dtype='>i4'),
         'flags': np.array([True, False]), 'names': np.array(['a', 'bc']), 'number': np.float32(1.5),
         'whole': np.int64(9), 'empty': np.zeros((0, 3)), 'objects': np.array([{'k': 1}, None], dtype=object)}
value['again'] = value['doubles']
for p in range(6):
    pickle.dump(value, open(f'{p}.pkl', 'wb'), protocol=p)
np.savez('objects.npz', positions=value)
np.save('objects.npy', np.array([value], dtype=object))
)");
  if (!there) GTEST_SKIP() << "no Python with NumPy";
  for (int p = 0; p < 6; ++p) {
    const Pickle pickle = read_pickle(folder / (std::to_string(p) + ".pkl"));
    SCOPED_TRACE(pickle.subject);
    const auto at = [&](const char* key) -> const PickleValue& { return pickle.at(*pickle.root, key); };
    EXPECT_EQ(shown(at("none")) + shown(at("yes")) + shown(at("no")), "NoneTrueFalse");
    EXPECT_EQ(shown(at("small")) + shown(at("minus")) + shown(at("long")), "7-300-1099511627776");
    EXPECT_EQ(shown(at("real")), "0.250000");
    EXPECT_EQ(at("text").text, "l\xC3\xA4nger\n\\");
    ASSERT_EQ(shown(at("bytes")), "b256");
    for (int i = 0; i < 256; ++i) EXPECT_EQ(static_cast<unsigned char>(at("bytes").text[static_cast<size_t>(i)]), i);
    EXPECT_EQ(shown(at("list")), "[1 [2 () ] (3 ) (4 5 ) (6 7 8 9 ) ]");
    EXPECT_EQ(shown(at("set")) + shown(at("frozen")), "set(5 )set(6 )");
    EXPECT_TRUE(torch::equal(at("doubles").array, torch::arange(12).to(torch::kDouble).view({3, 4}) / 8));
    EXPECT_EQ(&at("again"), &at("doubles"));
    EXPECT_TRUE(torch::equal(at("fortran").array, torch::arange(6).to(torch::kFloat).view({2, 3})));
    EXPECT_TRUE(torch::equal(at("big").array, torch::arange(3).to(torch::kInt)));
    EXPECT_TRUE(torch::equal(at("flags").array, torch::tensor({1, 0}).ne(0)));
    EXPECT_EQ(at("names").texts.values, (std::vector<std::string>{"a", "bc"}));
    EXPECT_EQ(shown(at("number")) + shown(at("whole")), "1.5000009");
    EXPECT_EQ(at("empty").array.sizes(), (std::vector<int64_t>{0, 3}));
    EXPECT_EQ(shown(at("objects")), "[{'k' 1 } None ]");
    EXPECT_TRUE(torch::equal(pickle.numbers_at(*pickle.root, "number"), torch::tensor(1.5F)));
    EXPECT_NE(refusal_of([&] { pickle.numbers_at(*pickle.root, "text"); }).find("its text is neither"),
              std::string::npos);
    EXPECT_NE(refusal_of([&] { pickle.at(*pickle.root, "trans"); }).find("has no \"trans\" (it has none, yes, no"),
              std::string::npos);
  }
  for (const char* file : {"objects.npz", "objects.npy"}) {
    const bool npz = std::string(file) == "objects.npz";
    const Pickle pickle = read_npz_objects(folder / file, npz ? "positions" : "arr_0");
    EXPECT_EQ(shown(pickle.at(*pickle.root, "small")), "7") << file;
  }
}

// {'trans': array([0., 1., 2.])} of Python 2, where arrays lie in its own kind of text.
const std::string kSeeds = INHABIT_SOURCE_DIR "/tests/fuzz/seeds/pickle/";

TEST(Pickle, ReadsPythonTwo) {
  const Pickle pickle = read_pickle(kSeeds + "python2.pkl");
  EXPECT_TRUE(torch::equal(pickle.numbers_at(*pickle.root, "trans"), torch::arange(3).to(torch::kFloat)));
  const Pickle old = parse_pickle("(dp0\nS'a\\x41\\'\\n'\np1\nI12\nsS'b'\nL-5L\nsS'c'\nI01\nsS'd'\nF1e-1\ns.", "x");
  EXPECT_EQ(shown(*old.root), "{'aA'\n' 12 'b' -5 'c' True 'd' 0.100000 }");
}

TEST(Pickle, NeverLoadsClassesOrFunctions) {
  const std::string system = refused("cos\nsystem\n(S'touch /tmp/x'\ntR.");
  EXPECT_EQ(system, "x.pkl: needs os.system, which is neither a plain value nor a NumPy array: it is not loaded");
  EXPECT_NE(refused(std::string("\x80\x04\x8c\x08") + "builtins\x8c\x04" + "eval\x93.").find("needs builtins.eval"),
            std::string::npos);
  EXPECT_NE(refused("(ios\nsystem\n.").find("needs os.system"), std::string::npos);
  EXPECT_NE(refused("cnumpy\nsave\n.").find("needs numpy.save"), std::string::npos);
  EXPECT_NE(refused("c\x1b[2J\nx\n.").find("needs ?[2J.x"), std::string::npos);
  EXPECT_NE(refused("P12\n.").find("refers to something outside"), std::string::npos);
  EXPECT_NE(refused("I1\n(tR.").find("is no function"), std::string::npos);
  EXPECT_NE(refused("cnumpy\ndtype\n.").find("where a value is expected"), std::string::npos);
  EXPECT_NE(refused("(lI1\nb.").find("no NumPy array"), std::string::npos);
}

TEST(Pickle, RefusesWhatIsDamagedOrHostile) {
  EXPECT_EQ(refused(""), "x.pkl: is empty");
  EXPECT_NE(refused("hello").find("x.pkl: is no pickle"), std::string::npos);
  for (const char* seed : {"protocol0.pkl", "protocol2.pkl", "protocol4.pkl", "protocol5.pkl", "python2.pkl"}) {
    const std::string whole = read_whole_file(kSeeds + seed);
    EXPECT_EQ(refused(whole), "") << seed;
    for (size_t n = 0; n < whole.size(); ++n) EXPECT_NE(refused(whole.substr(0, n)), "") << seed << " " << n;
  }
  // Sizes that are not there.
  EXPECT_EQ(refused(std::string("X\xff\xff\xff\x7f") + "a."), "x.pkl: ends early");
  EXPECT_EQ(refused(std::string("\x80\x04\x8e\xff\xff\xff\xff\xff\xff\xff\xff.")), "x.pkl: ends early");
  EXPECT_NE(refused("\x80\x09.").find("newer protocol"), std::string::npos);
  const auto array = [](const std::string& shape, const std::string& type) {
    return "cnumpy.core.multiarray\n_reconstruct\n(cnumpy\nndarray\n(I0\ntS'b'\ntR(I1\n" + shape +
           "cnumpy\ndtype\n(S'" + type + "'\nI0\nI1\ntRI00\nS'12345678'\ntb.";
  };
  EXPECT_EQ(refused(array("(I2\nt", "f4")), "");
  EXPECT_NE(refused(array("(I3\nt", "f4")).find("ends early"), std::string::npos);
  EXPECT_NE(refused(array("(I1\nt", "f4")).find("more bytes than its shape"), std::string::npos);
  EXPECT_NE(refused(array("(I-1\nt", "f4")).find("shape of a NumPy array"), std::string::npos);
  EXPECT_NE(refused(array("(I9223372036854775807\nI9223372036854775807\nt", "f4")).find("beyond 64 bits"),
            std::string::npos);
  EXPECT_NE(refused(array("(I922337203685477580\nI922337203685477580\nt", "f4")).find("absurd"), std::string::npos);
  EXPECT_NE(refused(array("(I1\nt", "c8")).find("of type"), std::string::npos);
  // Values in one another, and in themselves.
  EXPECT_EQ(refused(std::string(99, ']') + std::string(98, 'a') + "."), "");
  EXPECT_NE(refused(std::string(300, ']') + std::string(299, 'a') + ".").find("100 deep"), std::string::npos);
  EXPECT_EQ(refused("]q\x01h\x01"
                    "a."),
            "x.pkl: holds a value that contains itself");
  EXPECT_NE(refused("h\x05.").find("has not stored"), std::string::npos);
  EXPECT_NE(refused("I1\nt.").find("no mark"), std::string::npos);
  EXPECT_NE(refused("(I1\nd.").find("key without a value"), std::string::npos);
  EXPECT_NE(refused("(.").find("stack is empty"), std::string::npos);
  EXPECT_NE(refused("L99999999999999999999L\n.").find("beyond 64 bits"), std::string::npos);
  // A list of two references to a list of two references...: shared, so small.
  std::string doubled("]q\0", 3);
  for (int k = 0; k < 30; ++k) doubled += std::string("](h") + '\0' + "h" + '\0' + "eq" + '\0';
  EXPECT_EQ(refused(doubled + "."), "");
}

TEST(Pickle, ANumberIsOneAndFinite) {
  const Pickle p = parse_pickle("(dVone\nF1.5\nsVtwo\n(lI1\naI2\nasVfar\nF1e60\nsVnone\nNs.", "x.pkl");
  EXPECT_EQ(p.number_at(*p.root, "one"), 1.5);
  for (const char* key : {"two", "far", "none", "other"})
    EXPECT_NE(refusal_of([&] { p.number_at(*p.root, key); }).find("x.pkl"), std::string::npos) << key;
}

TEST(NpyRows, ReadsSomeRowsOfAFile) {
  const TempFolder folder;
  const torch::Tensor all = torch::arange(30).to(torch::kInt).view({10, 3});
  write_npy(folder / "a.npy", all);
  int64_t rows = 0;
  EXPECT_TRUE(torch::equal(read_npy_rows(folder / "a.npy", 4, 3, &rows).at("arr_0", ""), all.slice(0, 4, 7)));
  EXPECT_EQ(rows, 10);
  EXPECT_EQ(read_npy_rows(folder / "a.npy", 8, 99).at("arr_0", "").size(0), 2);
  EXPECT_EQ(read_npy_rows(folder / "a.npy", 12, 1).at("arr_0", "").size(0), 0);
  write_atomically(folder / "names.npy", npy_bytes(StringArray{{3}, {"a", "bcd", "e"}}));
  EXPECT_EQ(read_npy_rows(folder / "names.npy", 1, 1).strings.at("arr_0").values, std::vector<std::string>{"bcd"});
  const std::string whole = read_whole_file(folder / "a.npy");
  write_atomically(folder / "short.npy", whole.substr(0, whole.size() - 4));
  EXPECT_NE(refusal_of([&] { read_npy_rows(folder / "short.npy", 0, 1); }).find("ends early"), std::string::npos);
  EXPECT_NE(refusal_of([&] { read_npy_rows(folder / "none.npy", 0, 1); }).find("no such file"), std::string::npos);
}

}  // namespace
}  // namespace inhabit
