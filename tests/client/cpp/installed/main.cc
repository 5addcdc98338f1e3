#include <client/cpp/client.h>

#include <cstdio>

int main() {
  try {
    mwidth::client::Client::Connect("127.0.0.1:1");
  } catch (const mwidth::client::Error& error) {
    std::puts(error.what());
  }
}
